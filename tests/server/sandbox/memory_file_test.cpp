#include "server/sandbox/memory_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include <doctest/doctest.h>

using namespace meshgauge::server;
using namespace meshgauge::server::sandbox;

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
