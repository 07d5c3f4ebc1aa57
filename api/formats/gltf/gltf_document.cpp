#include "api/formats/gltf/gltf_document.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/formats/file/file_path.h"
#include "api/formats/gltf/gltf_extensions.h"

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

// The members of a glTF's JSON that are read, with their types and ranges.
enum class Kind { index, size, flag, text, name, numbers, indices, texts, object, objects, more_joints };

// A member that is read; all others are dropped. `members`: for objects. `count`: for arrays of numbers; 0: any.
struct Field {
  std::string_view name;
  Kind kind = Kind::index;
  bool required = false;
  std::size_t count = 0;
  std::span<const Field> members = {};
};

constexpr Field kAsset[] = {{"version", Kind::text, true}};
constexpr Field kScene[] = {{"nodes", Kind::indices}};
constexpr Field kInstanceAttributes[] = {
    {"TRANSLATION", Kind::index}, {"ROTATION", Kind::index}, {"SCALE", Kind::index}};
constexpr Field kInstancing[] = {{"attributes", Kind::object, true, 0, kInstanceAttributes}};
constexpr Field kVisibility[] = {{"visible", Kind::flag}};
constexpr Field kNodeExtensions[] = {{"EXT_mesh_gpu_instancing", Kind::object, false, 0, kInstancing},
                                     {"KHR_node_visibility", Kind::object, false, 0, kVisibility}};
constexpr Field kNode[] = {{"name", Kind::name},
                           {"mesh", Kind::index},
                           {"skin", Kind::index},
                           {"weights", Kind::numbers},
                           {"children", Kind::indices},
                           {"matrix", Kind::numbers, false, 16},
                           {"rotation", Kind::numbers, false, 4},
                           {"scale", Kind::numbers, false, 3},
                           {"translation", Kind::numbers, false, 3},
                           {"extensions", Kind::object, false, 0, kNodeExtensions}};
constexpr Field kSkin[] = {{"joints", Kind::indices, true}, {"inverseBindMatrices", Kind::index}};
constexpr Field kAttributes[] = {{"POSITION", Kind::index},      {"JOINTS_0", Kind::index},  {"WEIGHTS_0", Kind::index},
                                 {"JOINTS_1", Kind::index},      {"WEIGHTS_1", Kind::index}, {"JOINTS_2", Kind::index},
                                 {"WEIGHTS_2", Kind::index},     {"JOINTS_3", Kind::index},  {"WEIGHTS_3", Kind::index},
                                 {"JOINTS_4", Kind::more_joints}};
constexpr Field kDraco[] = {{"bufferView", Kind::index, true}, {"attributes", Kind::object, true, 0, kAttributes}};
constexpr Field kPrimitiveExtensions[] = {{"KHR_draco_mesh_compression", Kind::object, false, 0, kDraco}};
constexpr Field kTarget[] = {{"POSITION", Kind::index}};
constexpr Field kPrimitive[] = {{"attributes", Kind::object, true, 0, kAttributes},
                                {"indices", Kind::index},
                                {"mode", Kind::index},
                                {"targets", Kind::objects, false, 0, kTarget},
                                {"extensions", Kind::object, false, 0, kPrimitiveExtensions}};
constexpr Field kMesh[] = {{"primitives", Kind::objects, true, 0, kPrimitive}, {"weights", Kind::numbers}};
constexpr Field kSparseIndices[] = {
    {"bufferView", Kind::index, true}, {"byteOffset", Kind::index}, {"componentType", Kind::index, true}};
constexpr Field kSparseValues[] = {{"bufferView", Kind::index, true}, {"byteOffset", Kind::index}};
constexpr Field kSparse[] = {{"count", Kind::index, true},
                             {"indices", Kind::object, true, 0, kSparseIndices},
                             {"values", Kind::object, true, 0, kSparseValues}};
constexpr Field kAccessor[] = {{"bufferView", Kind::index},
                               {"byteOffset", Kind::size},
                               {"componentType", Kind::index, true},
                               {"count", Kind::size, true},
                               {"type", Kind::text, true},
                               {"normalized", Kind::flag},
                               {"sparse", Kind::object, false, 0, kSparse}};
constexpr Field kMeshopt[] = {{"buffer", Kind::index, true},
                              {"byteOffset", Kind::size},
                              {"byteLength", Kind::size, true},
                              {"byteStride", Kind::size, true},
                              {"count", Kind::size, true},
                              {"mode", Kind::text, true},
                              {"filter", Kind::text}};
constexpr Field kViewExtensions[] = {{"EXT_meshopt_compression", Kind::object, false, 0, kMeshopt},
                                     {"KHR_meshopt_compression", Kind::object, false, 0, kMeshopt}};
constexpr Field kBufferView[] = {{"buffer", Kind::index, true},
                                 {"byteOffset", Kind::size},
                                 {"byteLength", Kind::size, true},
                                 {"byteStride", Kind::size},
                                 {"extensions", Kind::object, false, 0, kViewExtensions}};
constexpr Field kFallback[] = {{"fallback", Kind::flag}};
constexpr Field kBufferExtensions[] = {{"EXT_meshopt_compression", Kind::object, false, 0, kFallback},
                                       {"KHR_meshopt_compression", Kind::object, false, 0, kFallback}};
constexpr Field kBuffer[] = {
    {"byteLength", Kind::size, true}, {"uri", Kind::text}, {"extensions", Kind::object, false, 0, kBufferExtensions}};
constexpr Field kRoot[] = {{"asset", Kind::object, true, 0, kAsset},
                           {"extensionsUsed", Kind::texts},
                           {"extensionsRequired", Kind::texts},
                           {"scene", Kind::index},
                           {"scenes", Kind::objects, false, 0, kScene},
                           {"nodes", Kind::objects, false, 0, kNode},
                           {"skins", Kind::objects, false, 0, kSkin},
                           {"meshes", Kind::objects, false, 0, kMesh},
                           {"accessors", Kind::objects, false, 0, kAccessor},
                           {"bufferViews", Kind::objects, false, 0, kBufferView},
                           {"buffers", Kind::objects, false, 0, kBuffer}};

// A place in the document; turned into text only for an error.
struct Path {
  const Path* parent = nullptr;
  std::string_view name;
  std::size_t index = std::numeric_limits<std::size_t>::max();

  std::string words() const {
    std::string out = parent == nullptr ? "" : parent->words();
    if (!name.empty()) out += (out.empty() ? "" : ".") + std::string(name);
    if (index != std::numeric_limits<std::size_t>::max()) out += "[" + std::to_string(index) + "]";
    return out;
  }
};

class Checker {
 public:
  explicit Checker(const Source& source) : source_(source) {}

  // Writes the known members of `in` to `out`. false: one of them is invalid, error() has the defect.
  bool object(const json& in, std::span<const Field> fields, const Path& path, json& out);
  Error error() { return std::move(*error_); }

 private:
  bool value(const json& in, const Field& field, const Path& path, json& out);
  bool integer(const json& in, double most, const Path& path, json& out);
  bool numbers(const json& in, std::size_t count, const Path& path, json& out);
  // Copies an array by copy(item, place, out) of each item. `of`: what the items are, in words.
  template <class Copy>
  bool array(const json& in, const char* of, const Path& path, json& out, const Copy& copy) {
    if (!in.is_array()) return fail(path, std::string("expected an array of ") + of);
    out = json::array();
    for (const json& item : in) {
      json& its = out.emplace_back();
      if (!copy(item, Path{&path, "", out.size() - 1}, its)) return false;
    }
    return true;
  }
  bool texts(const json& in, const Path& path, json& out);
  bool fail(const Path& path, const std::string& what, ErrorCode code = ErrorCode::unreadable_mesh) {
    const std::string where = path.words();
    error_ = at(source_, where.empty() ? "the glTF" : where, code, what);
    return false;
  }

  const Source& source_;
  std::optional<Error> error_;
};

// Accepts 24.0 as an integer: JSON does not distinguish it from 24.
bool Checker::integer(const json& in, double most, const Path& path, json& out) {
  const double number = in.is_number() ? in.get<double>() : -1;
  if (number < 0 || number > most || number != std::floor(number)) {
    return fail(path, "expected an integer from 0 to " + std::to_string(static_cast<std::uint64_t>(most)));
  }
  out = static_cast<std::uint64_t>(number);
  return true;
}

bool Checker::numbers(const json& in, std::size_t count, const Path& path, json& out) {
  const bool ok = in.is_array() && (count == 0 || in.size() == count) &&
                  std::ranges::all_of(
                      in, [](const json& number) { return number.is_number() && std::isfinite(number.get<double>()); });
  if (!ok) return fail(path, "expected an array of " + (count == 0 ? "" : std::to_string(count) + " ") + "numbers");
  out = in;
  return true;
}

bool Checker::texts(const json& in, const Path& path, json& out) {
  if (!in.is_array() || !std::ranges::all_of(in, [](const json& item) { return item.is_string(); })) {
    return fail(path, "expected an array of strings");
  }
  out = in;
  return true;
}

bool Checker::value(const json& in, const Field& field, const Path& path, json& out) {
  const auto index = [this](const json& item, const Path& place, json& copy) {
    return integer(item, std::numeric_limits<std::int32_t>::max(), place, copy);
  };
  const auto member = [&](const json& item, const Path& place, json& copy) {
    return object(item, field.members, place, copy);
  };
  switch (field.kind) {
    case Kind::index:
      return index(in, path, out);
    case Kind::size:
      return integer(in, 0x1p53, path, out);
    case Kind::numbers:
      return numbers(in, field.count, path, out);
    case Kind::indices:
      return array(in, "indices", path, out, index);
    case Kind::texts:
      return texts(in, path, out);
    case Kind::object:
      return member(in, path, out);
    case Kind::objects:
      return array(in, "objects", path, out, member);
    case Kind::more_joints:
      return fail(path, "more than 16 joints a vertex are not supported; save the model with at most 16",
                  ErrorCode::unsupported_format);
    case Kind::name:  // a name that cannot be asked for is read as ""
      out = in.is_string() && is_group_name(in.get_ref<const std::string&>()) ? in : json("");
      return true;
    case Kind::flag:
      if (!in.is_boolean()) return fail(path, "expected true or false");
      break;
    case Kind::text:
      if (!in.is_string()) return fail(path, "expected a string");
      break;
  }
  out = in;
  return true;
}

bool Checker::object(const json& in, std::span<const Field> fields, const Path& path, json& out) {
  if (!in.is_object()) return fail(path, "expected an object");
  out = json::object();
  for (const Field& field : fields) {
    const Path member{&path, field.name};
    const auto found = in.find(field.name);
    if (found == in.end()) {
      if (field.required) return fail(member, "missing");
      continue;
    }
    if (!value(*found, field, member, out[std::string(field.name)])) return false;
  }
  return true;
}

// Returns the members that make up the surface, buffers and extensions included, without all others. Errors name the
// member. Precondition: not nested too deep for recursion.
Result<json> take_gltf_members(const Source& source, const json& document) {
  Checker checker(source);
  json members;
  if (!checker.object(document, kRoot, Path{}, members)) return checker.error();
  return members;
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
