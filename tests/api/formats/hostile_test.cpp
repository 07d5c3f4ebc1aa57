// Damaged files of every format: cut at every length, and with bytes changed at random. Each is read or refused with
// a message; what is read holds together. Run under a sanitizer, this is a small fuzzer.
#include <doctest/doctest.h>

#include <algorithm>
#include <initializer_list>
#include <random>

#include "tests/api/formats/files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

struct Sample {
  std::string name;
  std::string content;
  std::string (*wrap)(const std::string& content) = nullptr;  // makes the content a file, where it is none by itself

  std::string file(const std::string& changed) const { return wrap == nullptr ? changed : wrap(changed); }
};

std::string binary_stl() {
  std::string out = std::string(80, 'h') + raw(std::uint32_t{2});
  for (int facet = 0; facet < 2; ++facet) {
    for (int k = 0; k < 12; ++k) out += raw(static_cast<float>(k * k) * 0.25F);
    out += std::string(2, '\0');
  }
  return out;
}

std::string binary_ply() {
  std::string out =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty double z\n"
      "element other 1\nproperty list uchar short s\nelement face 2\nproperty list uchar int vertex_indices\n"
      "end_header\n";
  for (int i = 0; i < 3; ++i) out += raw(static_cast<float>(i)) + raw(static_cast<float>(i * i)) + raw(0.5 * i);
  out += "\x02" + std::string(4, 's');
  for (int face = 0; face < 2; ++face) {
    out += '\x03';
    for (const std::int32_t i : {0, 1, 2}) out += raw(i);
  }
  return out;
}

std::string glb() {
  std::string json =
      R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"children":[1],"scale":[2,2,2]},{"mesh":0}],)"
      R"("meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],"buffers":[{"byteLength":44}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices":)"
      R"({"bufferView":1,"componentType":5123},"values":{"bufferView":0}}},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"}]})";
  while (json.size() % 4 != 0) json += ' ';
  std::string data;
  for (int k = 0; k < 9; ++k) data += raw(static_cast<float>(k * k));
  for (const int i : {0, 1, 2, 0}) data += raw(static_cast<std::uint16_t>(i));
  const std::string chunks = raw(static_cast<std::uint32_t>(json.size())) + "JSON" + json +
                             raw(static_cast<std::uint32_t>(data.size())) + std::string("BIN\0", 4) + data;
  return "glTF" + raw(std::uint32_t{2}) + raw(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

std::string assembled_model() {
  return model(triangle_object(1) +
                   "<object id=\"2\"><components><component objectid=\"1\" "
                   "transform=\"1 0 0 0 1 0 0 0 1 0 0 1\"/></components></object>",
               "<item objectid=\"2\"/><item objectid=\"1\"/>", "unit=\"inch\"");
}

std::vector<Sample> samples() {
  return {{"m.obj",
           "# part\nv 0 0 0 1\nv 1.5e-3 +2 .5\r\nv -1 2. 3\nvn 0 0 1\ng a b\\\nc\nf 1//1 2/3/4 -1\nf 1 2 \\\n3 1\n"},
          {"m.stl", binary_stl()},
          {"a.stl",
           "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1e0 0 0\nvertex 0 1 -0\n"
           "endloop\nendfacet\nendsolid x\n"},
          {"m.ply", binary_ply()},
          {"a.ply",
           "ply\nformat ascii 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0.5\n3 0 1 2\n"},
          {"s.ply",
           "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
           "element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
           "0 0 0\n1 0 0\n0 1 0.5\n7 0 1 2 -1 2 1 0\n"},
          {"n.off", "STCNOFF\n3 1 3\n0 0 0 0 0 1 9 9 9 .5 .5\n1 0 0 0 0 1 9 9 9 1 1\n0 1 0 0 0 1 9 9 9 0 0\n3 0 1 2\n"},
          {"m.3mf", package(assembled_model())},
          {"x.3mf", assembled_model(), [](const std::string& content) { return package(content); }},
          {"m.obj.gz", gzipped("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")},
          {"m.off", "OFF # kind\n3 1 3\n0 0 0\n1 0 0\n0 1e-1 0\n3 0 1 2 0.5 0.5 0.5\n"},
          {"m.glb", glb()},
          {"m.gltf", glb().substr(20, glb().find("BIN") - 24)}};
}

bool is_one_of(const std::string& name, std::initializer_list<std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

void check_sound(const std::string& content, const std::string& name) {
  ReadLimits limits;
  limits.max_vertices = 10'000;
  limits.max_triangles = 10'000;
  limits.max_expanded_bytes = 1'000'000;
  const auto result = read(content, name, limits);
  if (!result) {
    REQUIRE(result.error().part == "a");
    REQUIRE(contains(result.error().message, "'a'"));
    REQUIRE(result.error().code != ErrorCode::internal);
    return;
  }
  const auto valid = validate(result->mesh, MeshLimits{10'000, 10'000}, "a");
  REQUIRE(valid.ok());
}

}  // namespace

TEST_CASE("hostile: the samples are good but for the glTF without its data") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    CHECK(read(sample.file(sample.content), sample.name).ok() == (sample.name != "m.gltf"));
  }
}

TEST_CASE("hostile: a file cut at any length is read or refused") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    for (std::size_t length = 0; length < sample.content.size(); ++length) {
      check_sound(sample.file(sample.content.substr(0, length)), sample.name);
      check_sound(sample.file(sample.content.substr(length)), sample.name);
    }
  }
}

TEST_CASE("hostile: a binary file that is cut is never read") {
  for (const Sample& sample : samples()) {
    if (!is_one_of(sample.name, {"m.stl", "m.ply", "m.glb", "m.3mf", "m.obj.gz"})) continue;
    for (std::size_t length = 0; length < sample.content.size(); ++length) {
      CAPTURE(length);
      CHECK(!read(sample.content.substr(0, length), sample.name).ok());
    }
  }
}

// Where the format has a count, a size or a checksum to go by, one changed bit is noticed or leaves all triangles.
TEST_CASE("hostile: each bit changed is read or refused, and never with fewer triangles where that can be told") {
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    const auto whole = read(sample.file(sample.content), sample.name);
    const bool counts = is_one_of(sample.name, {"m.stl", "m.3mf", "m.obj.gz"});
    for (std::size_t i = 0; i < 8 * sample.content.size(); ++i) {
      std::string content = sample.content;
      content[i / 8] = static_cast<char>(content[i / 8] ^ (1 << (i % 8)));
      check_sound(sample.file(content), sample.name);
      if (!counts) continue;
      const auto changed = read(content, sample.name);
      CAPTURE(i);
      if (changed) CHECK(changed->mesh.triangles == whole->mesh.triangles);
    }
  }
}

TEST_CASE("hostile: changed, doubled and lost bytes are read or refused") {
  std::mt19937_64 random(17);
  const auto pick = [&](std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); };
  constexpr char kInteresting[] = "\0\xFF\x7F\x80 \n\r\\/-+.eE09,[]{}\":#";
  for (const Sample& sample : samples()) {
    CAPTURE(sample.name);
    for (int round = 0; round < 4000; ++round) {
      std::string content = sample.content;
      for (std::size_t changes = 1 + pick(4); changes > 0; --changes) {
        const std::size_t at = pick(content.size());
        switch (pick(4)) {
          case 0:
            content[at] = static_cast<char>(pick(256));
            break;
          case 1:
            content[at] = kInteresting[pick(sizeof kInteresting)];
            break;
          case 2:
            content.erase(at, 1 + pick(8));
            break;
          default:
            content.insert(at, content.substr(pick(content.size()), pick(32)));
        }
        if (content.empty()) break;
      }
      check_sound(sample.file(content), sample.name);
    }
  }
}

TEST_CASE("hostile: every content under every name") {
  for (const Sample& content : samples()) {
    for (const Sample& name : samples()) check_sound(content.file(content.content), name.name);
    check_sound(content.file(content.content), "");
  }
}

}  // namespace meshgauge::api::test
