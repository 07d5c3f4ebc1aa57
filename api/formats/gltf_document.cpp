#include "api/formats/gltf_document.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/formats/file_path.h"
#include "api/formats/gltf_extensions.h"
#include "api/formats/gltf_members.h"
#include "api/formats/gltf_unread.h"

namespace meshgauge::api {
namespace {

using nlohmann::json;

constexpr int kDeepestValue = 64;
// A JSON object, even "{}", takes half a kilobyte as a node or an accessor of tinygltf. Real ones have tens of
// characters. These limits keep memory in proportion to the file.
constexpr std::size_t kMostValues = 4'000'000;
constexpr std::size_t kMostObjects = 500'000;
constexpr std::size_t kLeastObjectBytes = 12;  // on average, after the first thousand objects

// Checks depth and number of values before parsing, by counting brackets and commas outside strings.
Result<Done> check_size(const Source& source, std::string_view text) {
  const std::size_t most_objects = std::min(kMostObjects, 1000 + text.size() / kLeastObjectBytes);
  int depth = 0;
  std::size_t values = 0;
  std::size_t objects = 0;
  for (const char* p = text.data(); p != text.data() + text.size(); ++p) {
    if (*p == '"') {
      for (++p; p != text.data() + text.size() && *p != '"'; ++p) {
        if (*p == '\\' && p + 1 != text.data() + text.size()) ++p;
      }
      if (p == text.data() + text.size()) break;  // the parser reports the defect
    }
    depth += *p == '{' || *p == '[';
    depth -= *p == '}' || *p == ']';
    values += *p == ',' || *p == '[' || *p == '{';
    objects += *p == '{';
    if (depth > kDeepestValue || values > kMostValues || objects > most_objects) {
      return at_byte(source, static_cast<std::size_t>(p - source.begin()), ErrorCode::unreadable_mesh,
                     depth > kDeepestValue ? "glTF: JSON nested deeper than 64" : "glTF: too many values in the JSON");
    }
  }
  return Done{};
}

Result<json> parse(const Source& source, std::string_view text) {
  while (text.ends_with('\0')) text.remove_suffix(1);  // the padding of some GLB writers
  try {
    return json::parse(text);
  } catch (const json::parse_error& fault) {
    const std::size_t offset = static_cast<std::size_t>(text.data() - source.begin()) + fault.byte;
    return at_byte(source, offset, ErrorCode::unreadable_mesh, "glTF: not valid JSON");
  } catch (const json::exception&) {
    return about(source.part, ErrorCode::unreadable_mesh, "holds a number beyond the range of double in its JSON");
  }
}

// Returns asset.version, a string or a number below 2; empty: no such version.
std::string version_of(const json& whole) {
  const json* asset = whole.is_object() && whole.contains("asset") ? &whole["asset"] : nullptr;
  if (asset == nullptr || !asset->is_object() || !asset->contains("version")) return "";
  const json& version = (*asset)["version"];
  if (version.is_string()) return version.get<std::string>();
  return version.is_number() && version.get<double>() < 2 ? version.dump() : "";
}

// Checks the version before the members, which differ between versions. glTF 1.0 has maps of named objects where glTF
// 2.0 has arrays, and may lack a version.
Result<Done> check_version(const Source& source, const json& whole) {
  const std::string version = version_of(whole);
  const bool has_maps = whole.is_object() && whole.contains("meshes") && whole["meshes"].is_object();
  if (version == "1" || version.starts_with("1.") || (version.empty() && has_maps)) return gltf_1_error(source);
  if (version.empty() || version.starts_with("2.")) return Done{};  // take_gltf_members() reports a missing one
  return at(source, "asset.version", ErrorCode::unsupported_format,
            "glTF " + in_quotes(version) + " is not supported; save the model as glTF 2.0");
}

void take_buffers(json& root, GltfDocument& out) {
  for (json& buffer : root.value("buffers", json::array())) {
    GltfBuffer taken;
    taken.byte_length = buffer["byteLength"].get<std::size_t>();
    if (buffer.contains("uri")) taken.uri = std::move(buffer["uri"].get_ref<std::string&>());
    taken.fallback = is_gltf_fallback(buffer);
    out.buffers.push_back(std::move(taken));
  }
}

// Checks all URIs before any file is looked up: a file may be missing because another name was refused.
Result<Done> check_uris(const Source& source, const std::vector<GltfBuffer>& buffers) {
  std::map<std::string, std::string> paths;  // key: file_key()
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    if (!buffers[i].is_external()) continue;
    FilePath file = file_path_of_uri(buffers[i].uri);
    const std::string first = file.defect.empty() ? paths.emplace(file_key(file.path), file.path).first->second : "";
    if (file.defect.empty() && first != file.path) {
      file.defect = "differs from " + in_quotes(first) + " by letter case alone: rename one of the files";
    }
    if (file.defect.empty()) continue;
    return at(source, "buffers[" + std::to_string(i) + "].uri", ErrorCode::unreadable_mesh,
              in_quotes(buffers[i].uri) + " " + file.defect);
  }
  return Done{};
}

Result<GltfDocument> reduce(const Source& source, const json& whole) {
  if (auto ok = check_version(source, whole); !ok) return std::move(ok).error();
  auto members = take_gltf_members(source, whole);
  if (!members) return std::move(members).error();
  json& root = *members;
  GltfDocument out;
  if (auto ok = take_gltf_extensions(source, root, out); !ok) return std::move(ok).error();
  count_gltf_unread(whole, out);
  take_buffers(root, out);
  if (auto ok = check_uris(source, out.buffers); !ok) return std::move(ok).error();
  root.erase("buffers");
  out.json = root.dump();
  return out;
}

}  // namespace

Result<GltfDocument> check_gltf(const Source& source, std::string_view text) {
  if (auto ok = check_size(source, text); !ok) return std::move(ok).error();
  const auto whole = parse(source, text);
  if (!whole) return whole.error();
  return reduce(source, *whole);
}

}  // namespace meshgauge::api
