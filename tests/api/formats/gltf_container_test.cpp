#include "api/formats/gltf_container.h"

#include <doctest/doctest.h>

#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {

TEST_CASE("gltf: malformed containers are refused with their byte") {
  const std::string text = tetrahedron().dump();
  const std::string whole = glb(tetrahedron());
  const std::string json_chunk = chunk("JSON", text, ' ');
  const std::string bin_chunk = chunk(std::string("BIN\0", 4), tetrahedron_data(), '\0');
  CHECK(contains(refusal(container(json_chunk + bin_chunk, 3), ""), "byte 4 of 'a': GLB: version 3 is not supported"));
  CHECK(contains(refusal(whole.substr(0, whole.size() - 1), ""), "byte 8 of 'a': GLB: truncated"));
  CHECK(contains(refusal(whole + "x", ""), "left-over bytes"));
  CHECK(contains(refusal(container(bin_chunk + json_chunk), ""), "byte 12 of 'a': GLB: the first chunk"));
  CHECK(contains(refusal(container(json_chunk + json_chunk), ""), "the first chunk, and no other, must be JSON"));
  CHECK(contains(refusal(container(json_chunk + bin_chunk + bin_chunk), ""), "a BIN chunk must be the second chunk"));
  CHECK(contains(refusal(container(json_chunk + "abc"), ""), "truncated chunk header"));
  CHECK(contains(refusal(container(json_chunk), ""), "neither a URI nor a BIN chunk"));
  CHECK(contains(refusal(container(""), ""), "no JSON chunk"));
  std::string long_chunk = whole;
  long_chunk.replace(12, 4, raw(std::uint32_t{0xFFFFFFFC}));
  CHECK(contains(refusal(long_chunk, ""), "truncated: a chunk of 4294967292 bytes"));
  CHECK(mesh_of(container(json_chunk + bin_chunk + chunk("ABCD", "1234", ' '))).triangles.size() == 4);
  CHECK(mesh_of(container(chunk("JSON", text, '\0') + bin_chunk)).triangles.size() == 4);
  json two = tetrahedron();
  two["buffers"].push_back({{"byteLength", 72}});
  CHECK(contains(refusal(glb(two), ""), "buffers[1] of 'a': has no data"));
}

}  // namespace meshgauge::api::test
