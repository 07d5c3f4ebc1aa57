// Compressed and quantized glTF files against the reference decoders, to the last bit: libdraco's own interface and
// libmeshoptimizer, called on data that this test extracts from the file.
#include <bit>
#include <limits>
#include <map>

#include <doctest/doctest.h>
#include <draco/compression/decode.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include "tests/api/formats/files.h"
#include "tests/api/formats/gltf_files.h"

namespace meshgauge::api::test {
namespace {

struct Opened {
  json document;
  std::vector<std::string> buffers;
};

std::uint32_t word_at(const std::string& bytes, std::size_t offset) {
  std::uint32_t word = 0;
  std::memcpy(&word, bytes.data() + offset, sizeof word);
  return word;
}

std::string unbase64(std::string_view text) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0;
  int held = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<unsigned>(kDigits.find(c));
    held += 6;
    if (held < 8) continue;
    held -= 8;
    out += static_cast<char>(bits >> held & 255U);
  }
  return out;
}

// nullopt: a version or shape that this test does not know.
std::optional<Opened> open(const std::filesystem::path& path) {
  const std::string content = file_content(path);
  Opened out;
  if (content.starts_with("glTF")) {
    if (word_at(content, 4) != 2) return std::nullopt;
    const std::size_t length = word_at(content, 12);
    out.document = json::parse(content.substr(20, length), nullptr, false);
    if (content.size() > 28 + length) out.buffers.push_back(content.substr(28 + length, word_at(content, 20 + length)));
  } else {
    out.document = json::parse(content, nullptr, false);
  }
  if (!out.document.is_object() || !out.document.value("meshes", json()).is_array()) return std::nullopt;
  for (const json& buffer : out.document.value("buffers", json::array())) {
    const std::string uri = buffer.value("uri", "");
    if (uri.starts_with("data:")) out.buffers.push_back(unbase64(std::string_view(uri).substr(uri.find(',') + 1)));
    if (!uri.empty() && !uri.starts_with("data:")) return std::nullopt;
  }
  return out;
}

std::string piece(const Opened& file, const json& view) {
  return file.buffers.at(view["buffer"].get<std::size_t>()).substr(view.value("byteOffset", 0U), view["byteLength"]);
}

// Returns the bytes of a view, decompressed by libmeshoptimizer if necessary.
std::string view_bytes(const Opened& file, std::size_t index) {
  const json& view = file.document["bufferViews"].at(index);
  const json& extensions = view.value("extensions", json::object());
  const json meshopt = extensions.value("EXT_meshopt_compression", extensions.value("KHR_meshopt_compression", json()));
  if (meshopt.is_null()) return piece(file, view);
  const std::string stream = piece(file, meshopt);
  const auto* bytes = reinterpret_cast<const unsigned char*>(stream.data());
  const std::size_t count = meshopt["count"];
  const std::size_t stride = meshopt["byteStride"];
  std::string out(count * stride, '\0');
  const std::string mode = meshopt["mode"];
  const int result = mode == "ATTRIBUTES" ? meshopt_decodeVertexBuffer(out.data(), count, stride, bytes, stream.size())
                     : mode == "TRIANGLES"
                         ? meshopt_decodeIndexBuffer(out.data(), count, stride, bytes, stream.size())
                         : meshopt_decodeIndexSequence(out.data(), count, stride, bytes, stream.size());
  REQUIRE(result == 0);
  if (meshopt.value("filter", "NONE") == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), count, stride);
  return out;
}

template <class T>
double number(const char* p, bool normalized) {
  T value;
  std::memcpy(&value, p, sizeof value);
  const auto wide = static_cast<double>(value);
  return normalized ? std::max(wide / static_cast<double>(std::numeric_limits<T>::max()), -1.0) : wide;
}

double component(const char* p, int type, bool normalized) {
  switch (type) {
    case 5120:
      return number<std::int8_t>(p, normalized);
    case 5121:
      return number<std::uint8_t>(p, normalized);
    case 5122:
      return number<std::int16_t>(p, normalized);
    case 5123:
      return number<std::uint16_t>(p, normalized);
    case 5125:
      return number<std::uint32_t>(p, normalized);
    default:
      return number<float>(p, false);
  }
}

std::size_t bytes_of_type(int type) { return type < 5122 ? 1 : type < 5124 ? 2 : 4; }

std::vector<double> numbers(const Opened& file, std::size_t index, std::size_t components) {
  const json& accessor = file.document["accessors"].at(index);
  const std::size_t view = accessor["bufferView"];
  const std::string bytes = view_bytes(file, view);
  const int type = accessor["componentType"];
  const std::size_t size = bytes_of_type(type);
  const std::size_t stride = file.document["bufferViews"][view].value("byteStride", components * size);
  std::vector<double> out;
  for (std::size_t i = 0; i < accessor["count"].get<std::size_t>(); ++i) {
    for (std::size_t k = 0; k < components; ++k) {
      const std::size_t at = accessor.value("byteOffset", std::size_t{0}) + i * stride + k * size;
      REQUIRE(at + size <= bytes.size());
      out.push_back(component(bytes.data() + at, type, accessor.value("normalized", false)));
    }
  }
  return out;
}

// A primitive by the reference decoders, appended.
void add_draco(const Opened& file, const json& extension, std::vector<double>& positions,
               std::vector<double>& corners) {
  const std::string stream = view_bytes(file, extension["bufferView"]);
  draco::DecoderBuffer buffer;
  buffer.Init(stream.data(), stream.size());
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  REQUIRE(decoded.ok());
  const auto mesh = std::move(decoded).value();
  const auto* attribute = mesh->GetAttributeByUniqueId(extension["attributes"]["POSITION"].get<std::uint32_t>());
  REQUIRE(attribute != nullptr);
  const auto first = static_cast<double>(positions.size() / 3);
  for (std::uint32_t i = 0; i < mesh->num_points(); ++i) {
    float point[3];
    REQUIRE(attribute->ConvertValue<float, 3>(attribute->mapped_index(draco::PointIndex(i)), point));
    positions.insert(positions.end(), point, point + 3);
  }
  for (std::uint32_t i = 0; i < mesh->num_faces(); ++i) {
    for (const auto& corner : mesh->face(draco::FaceIndex(i))) corners.push_back(first + corner.value());
  }
}

// The document with every mesh once, where it stands, so that no transform comes in between; as a GLB of one buffer
// for each of its own.
json with_meshes_alone(const Opened& file) {
  json document = file.document;
  document["nodes"] = json::array();
  document["scenes"] = {{{"nodes", json::array()}}};
  document["scene"] = 0;
  for (std::size_t i = 0; i < document["meshes"].size(); ++i) {
    document["nodes"].push_back({{"mesh", i}});
    document["scenes"][0]["nodes"].push_back(i);
    for (json& primitive : document["meshes"][i]["primitives"]) primitive.erase("targets");
  }
  for (std::size_t i = 0; i < file.buffers.size(); ++i) {
    document["buffers"][i]["uri"] = "data:application/octet-stream;base64," + base64(file.buffers[i]);
  }
  return document;
}

bool is_compressed(const std::string& text) {
  return contains(text, "KHR_draco_mesh_compression") || contains(text, "meshopt_compression") ||
         contains(text, "KHR_mesh_quantization");
}

// Returns true when this test applies to the file.
bool check(const std::filesystem::path& path) {
  const auto file = open(path);
  if (!file || !is_compressed(file->document.dump())) return false;
  CAPTURE(path.string());
  std::vector<double> positions;
  std::vector<double> corners;
  for (const json& mesh : file->document["meshes"]) {
    std::map<std::size_t, double> known;
    for (const json& primitive : mesh["primitives"]) {
      const json draco = primitive.value("extensions", json::object()).value("KHR_draco_mesh_compression", json());
      REQUIRE(primitive.value("mode", 4) == 4);
      if (!draco.is_null()) {
        add_draco(*file, draco, positions, corners);
        continue;
      }
      const std::size_t accessor = primitive["attributes"]["POSITION"];
      if (!known.contains(accessor)) {
        known[accessor] = static_cast<double>(positions.size() / 3);
        const auto added = numbers(*file, accessor, 3);
        positions.insert(positions.end(), added.begin(), added.end());
      }
      for (const double corner : numbers(*file, primitive["indices"], 1)) corners.push_back(known[accessor] + corner);
    }
  }
  const Mesh read = mesh_of(with_meshes_alone(*file).dump());
  REQUIRE(read.positions.size() * 3 == positions.size());
  REQUIRE(read.triangles.size() * 3 == corners.size());
  bool same = true;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double ours = read.positions[i / 3][static_cast<int>(i % 3)];
    same = same && std::bit_cast<std::uint64_t>(ours + 0.0) == std::bit_cast<std::uint64_t>(positions[i] + 0.0);
  }
  CHECK(same);
  for (std::size_t i = 0; i < corners.size(); ++i) same = same && read.triangles[i / 3][i % 3] == corners[i];
  CHECK(same);
  return true;
}

}  // namespace

TEST_CASE("corpus: compressed and quantized glTF files are read as the reference decoders read them, bit by bit") {
  const auto root = corpus();
  if (!root) return;
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(*root)) {
    const auto extension = entry.path().extension();
    if ((extension != ".glb" && extension != ".gltf") || contains(entry.path().string(), "malformed")) continue;
    if (check(entry.path())) ++files;
  }
  MESSAGE(files << " files");
  CHECK(files >= 9);
}

}  // namespace meshgauge::api::test
