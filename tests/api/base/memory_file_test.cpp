#include "api/base/memory_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include <doctest/doctest.h>

using namespace meshgauge;

TEST_CASE("memory file: a copy holds the bytes and cannot be written to") {
  const std::string_view text = "v 0 0 0\n";
  const Descriptor file = sealed_copy(std::as_bytes(std::span(text)));
  REQUIRE(file);
  std::string back(text.size() + 1, '?');
  CHECK(::pread(file.get(), back.data(), back.size(), 0) == static_cast<ssize_t>(text.size()));
  CHECK(back == std::string(text) + '?');
  CHECK(::pwrite(file.get(), "x", 1, 0) < 0);
  CHECK(::mmap(nullptr, 8, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0) == MAP_FAILED);
  CHECK(sealed_copy({}));
}

TEST_CASE("memory file: a file of fixed size can be written to") {
  const SizedFile sized = file_of_size(8192);
  REQUIRE(sized.file);
  CHECK(sized.fixed);
  CHECK(::ftruncate(sized.file.get(), 1) != 0);
  CHECK(::ftruncate(sized.file.get(), 10'000) != 0);
  CHECK(::pwrite(sized.file.get(), "x", 1, 8191) == 1);
}

namespace {

// A pipe with this text in it, whose writer has gone. Returns the end to read.
Descriptor sent(std::string_view text) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  const Descriptor reader(ends[0]), writer(ends[1]);
  REQUIRE(write_all(writer.get(), std::as_bytes(std::span(text))));
  return Descriptor(::dup(reader.get()));
}

}  // namespace

TEST_CASE("memory file: what a pipe sends, to its end") {
  MemoryFile file;
  const std::string text(5000, 'x');
  CHECK(MemoryFile::read_all(sent(text).get(), 5000, file) == MemoryFile::End::whole);
  CHECK(std::string(reinterpret_cast<const char*>(file.bytes().data()), file.bytes().size()) == text);
  const MemoryFile moved = std::move(file);
  CHECK(moved.bytes().size() == 5000);
  CHECK(MemoryFile::read_all(sent("").get(), 0, file) == MemoryFile::End::whole);
  CHECK(file.bytes().empty());
}

TEST_CASE("memory file: a pipe that sends too much, and what cannot be read") {
  MemoryFile file;
  CHECK(MemoryFile::read_all(sent("12345").get(), 4, file) == MemoryFile::End::too_large);
  CHECK(MemoryFile::read_all(-1, 4, file) == MemoryFile::End::not_readable);
  CHECK(file.bytes().empty());
}
