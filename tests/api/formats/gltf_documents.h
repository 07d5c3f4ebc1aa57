// A tetrahedron as a glTF document, and the containers around it; without doctest, for programs other than tests.
#pragma once

#include <array>
#include <span>
#include <string>

#include <nlohmann/json.hpp>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {

using nlohmann::json;

inline constexpr std::array kIndices = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

template <class T>
std::string raw_all(std::span<const int> values) {
  std::string out;
  for (const int value : values) out += raw(static_cast<T>(value));
  return out;
}

// A tetrahedron: four vertices of float (bytes 0 to 47), twelve indices of 16 bits (48 to 71).
inline std::string tetrahedron_data() {
  std::string data;
  for (const float c : {0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F}) data += raw(c);
  return data + raw_all<std::uint16_t>(kIndices);
}

inline json tetrahedron() {
  return json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 72}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                  {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})");
}

inline std::string chunk(const std::string& type, std::string content, char padding) {
  while (content.size() % 4 != 0) content += padding;
  return raw(static_cast<std::uint32_t>(content.size())) + type + content;
}

inline std::string container(const std::string& chunks, std::uint32_t version = 2) {
  return "glTF" + raw(version) + raw(static_cast<std::uint32_t>(12 + chunks.size())) + chunks;
}

inline std::string glb(const json& document, const std::string& data = tetrahedron_data()) {
  return container(chunk("JSON", document.dump(), ' ') + chunk(std::string("BIN\0", 4), data, '\0'));
}

}  // namespace meshgauge::api::test
