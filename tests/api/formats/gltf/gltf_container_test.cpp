#include "api/formats/gltf/gltf_container.h"

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

TEST_CASE("gltf: bytes after the end of a GLB are noted") {
  const std::string whole = glb(tetrahedron());
  const Mesh expected = mesh_of(whole);
  for (const std::string& tail : {std::string("x"), std::string(4, '\0'), std::string("made with glTF tools, as JSON"),
                                  std::string(1000, 'B'), std::string("ABC\0WORD", 8)}) {
    CAPTURE(tail);
    const auto result = read(whole + tail, "m.glb");
    REQUIRE(result.ok());
    CHECK(result->mesh.positions == expected.positions);
    CHECK(result->mesh.triangles == expected.triangles);
    CHECK(result->notes.remarks ==
          std::vector<std::string>{"bytes after the end of the GLB, ignored: " + std::to_string(tail.size())});
  }
}

TEST_CASE("gltf: a chunk or another GLB after the end of a GLB is refused") {
  const std::string json_chunk = chunk("JSON", tetrahedron().dump(), ' ');
  const std::string bin_chunk = chunk(std::string("BIN\0", 4), tetrahedron_data(), '\0');
  const std::string whole = container(json_chunk + bin_chunk);
  const std::string end = "byte " + std::to_string(whole.size()) + " of 'a': GLB: ";
  const std::string lengths = ": the header says " + std::to_string(whole.size()) + " bytes, the file has ";
  CHECK(contains(refusal(whole + whole, ""), end + "another GLB after the end of the first; write each to a file"));
  CHECK(contains(refusal(whole + "glTF", ""), end + "another GLB after the end"));
  CHECK(contains(refusal(whole + std::string(52, '\0') + whole, ""), "another GLB after the end of the first"));
  for (const std::string& tail : {bin_chunk, json_chunk, bin_chunk.substr(0, 20)}) {
    CHECK(contains(refusal(whole + tail, ""), end + "left-over bytes: a chunk after the end" + lengths));
  }
  CHECK(contains(refusal(whole + std::string(3, '\0') + bin_chunk, ""), "left-over bytes: a chunk after the end"));

  const auto with_length = [&](std::size_t length) {
    std::string changed = whole;
    return changed.replace(8, 4, raw(static_cast<std::uint32_t>(length)));
  };
  const std::string has = " bytes, the file has " + std::to_string(whole.size());
  for (const std::size_t length : {std::size_t{0}, std::size_t{11}, std::size_t{15}, whole.size() - 1}) {
    CHECK(contains(refusal(with_length(length), ""),
                   "byte 8 of 'a': GLB: left-over bytes: the header says " + std::to_string(length) + has));
  }
  CHECK(contains(refusal(with_length(12), ""), "byte 12 of 'a': GLB: left-over bytes: a chunk after the end"));
  CHECK(contains(refusal(with_length(12 + json_chunk.size()), ""), "left-over bytes: a chunk after the end"));
}

}  // namespace meshgauge::api::test
