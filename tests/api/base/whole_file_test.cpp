#include "api/base/whole_file.h"

#include <sys/stat.h>

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::api;

namespace {

std::string text_of(const WholeFile& file) {
  return {reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()};
}

}  // namespace

TEST_CASE("whole file: its bytes, however large it is") {
  const test::Folder folder;
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, std::size_t{5'000'000}}) {
    const std::string text(size, 'x');
    CHECK(text_of(WholeFile::open(folder.write("mesh.obj", text).string()).value()) == text);
  }
}

TEST_CASE("whole file: later changes of the file do not matter") {
  const test::Folder folder;
  const std::string text(5'000'000, 'x');
  const auto path = folder.write("mesh.obj", text);
  const auto file = WholeFile::open(path.string());
  std::filesystem::resize_file(path, 3);  // a mapping's pages would be gone
  CHECK(text_of(file.value()) == text);
}

TEST_CASE("whole file: folders, pipes and unreadable files are refused") {
  const test::Folder folder;
  const std::string pipe = (folder / "pipe").string();
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  CHECK(WholeFile::open(pipe).error().message == "'" + pipe + "' is not a regular file");
  CHECK(WholeFile::open(folder.path().string()).error().message ==
        "'" + folder.path().string() + "' is a folder: name a file in it");
  const std::string none = (folder / "none").string();
  CHECK(WholeFile::open(none).error().message == "'" + none + "' cannot be read: No such file or directory");
  CHECK(WholeFile::open("/proc/self/status").error().message == "'/proc/self/status' was changed while it was read");
}
