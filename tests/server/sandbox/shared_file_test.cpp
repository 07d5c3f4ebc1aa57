#include "server/sandbox/shared_file.h"

#include <sys/mman.h>
#include <unistd.h>

#include <string>
#include <string_view>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server;
using namespace meshgauge::server::sandbox;

namespace {

const Mesh kSquare{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2}, {0, 2, 3}}};

Descriptor file_of(const Mesh& mesh) {
  Descriptor file = memory_file();
  const auto size = [](const auto& array) { return array.size() * sizeof array[0]; };
  REQUIRE(::write(file.get(), mesh.positions.data(), size(mesh.positions)) == 96);
  REQUIRE(::write(file.get(), mesh.triangles.data(), size(mesh.triangles)) == 24);
  return file;
}

}  // namespace

TEST_CASE("shared file: arrays come back where they were put") {
  const Descriptor file = file_of(kSquare);
  REQUIRE(seal(file.get()));
  const auto mesh = SharedMesh::map(file.get(), 4, 2);
  REQUIRE(mesh);
  CHECK(mesh->view().positions[2] == Vec3(1, 1, 0));
  CHECK(mesh->view().triangles[1] == Triangle{0, 2, 3});
  CHECK(mesh->view().positions.size() == 4);
  CHECK(mesh->view().triangles.size() == 2);
}

TEST_CASE("shared file: no other number of elements is believed") {
  const Descriptor file = file_of(kSquare);
  for (std::uint64_t vertices = 0; vertices < 8; ++vertices) {
    for (std::uint64_t triangles = 0; triangles < 12; ++triangles) {
      const bool fits = 2 * vertices + triangles == 10;
      CHECK((SharedMesh::map(file.get(), vertices, triangles) != nullptr) == fits);
    }
  }
  // 24 * 2^61 and 12 * 2^62 are 0 in 64 bits.
  CHECK(!SharedMesh::map(file.get(), (std::uint64_t{1} << 61) + 4, 2));
  CHECK(!SharedMesh::map(file.get(), 4, (std::uint64_t{1} << 62) + 2));
  CHECK(!SharedMesh::map(memory_file().get(), 0, 0));
}

TEST_CASE("shared file: what is sealed stays as it is") {
  const Descriptor file = file_of(kSquare);
  void* const hand = ::mmap(nullptr, 120, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0);
  REQUIRE(hand != MAP_FAILED);
  CHECK(!seal(file.get()));
  ::munmap(hand, 120);
  REQUIRE(seal(file.get()));
  CHECK(::pwrite(file.get(), "x", 1, 0) < 0);
  CHECK(::ftruncate(file.get(), 1) != 0);
  CHECK(::ftruncate(file.get(), 1000) != 0);
  CHECK(::mmap(nullptr, 120, PROT_READ | PROT_WRITE, MAP_SHARED, file.get(), 0) == MAP_FAILED);
}

TEST_CASE("shared file: a copy holds the bytes and cannot be written to") {
  const std::string_view text = "v 0 0 0\n";
  const Descriptor file = sealed_copy(std::as_bytes(std::span(text)));
  REQUIRE(file);
  std::string back(text.size() + 1, '?');
  CHECK(::pread(file.get(), back.data(), back.size(), 0) == static_cast<ssize_t>(text.size()));
  CHECK(back == std::string(text) + '?');
  CHECK(::pwrite(file.get(), "x", 1, 0) < 0);
  CHECK(sealed_copy({}));
}
