#include "server/measure/mesh_source.h"

#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

namespace meshgauge::server {
namespace {

using JsonValue = nlohmann::json;

constexpr std::size_t kMostHintBytes = 255;

// The end of a file's name tells its format.
std::string end_of(const std::string& name) { return name.substr(name.size() - std::min(name.size(), kMostHintBytes)); }

JsonValue hints_of(const MeshSource& source) {
  return {{"file_name", end_of(source.input.filename)},
          {"media_type", source.input.media_type.substr(0, kMostHintBytes)}};
}

// The store may have rows of other versions: a hint that is no text is ignored.
std::string text_at(const JsonValue& json, const char* part, const char* name) {
  const JsonValue::json_pointer pointer(std::string("/") + part + "/" + name);
  return json.contains(pointer) && json[pointer].is_string() ? json[pointer].get<std::string>() : std::string();
}

void set_hints(const JsonValue& json, MeshSource& source) {
  source.input.filename = text_at(json, source.input.part.c_str(), "file_name");
  source.input.media_type = text_at(json, source.input.part.c_str(), "media_type");
}

}  // namespace

MeshSource source_of(const std::string& part, MeshField mesh) {
  const std::shared_ptr<const Upload> upload = std::move(mesh.upload);
  return {{part, upload->bytes(), mesh.head.filename, mesh.head.content_type, upload->file()}, upload, "", {}};
}

MeshSource source_of(const std::string& part, store::Blob blob, const std::string& id) {
  MeshSource source{{part, {}, "", "", -1}, nullptr, id, {}};
  hold_bytes(source, std::move(blob));
  return source;
}

void hold_bytes(MeshSource& source, store::Blob blob) {
  const auto held = std::make_shared<const store::Blob>(std::move(blob));
  source.input.bytes = held->bytes();
  source.input.file = held->file();
  source.input.sha256 = source.id;
  source.holder = held;
}

void release_bytes(MeshSource& source) {
  source.input.bytes = {};
  source.input.file = -1;
  source.holder = nullptr;
}

std::string hints_of(const MeshSource& a, const MeshSource& b) {
  const JsonValue hints{{"a", hints_of(a)}, {"b", hints_of(b)}};
  return hints.dump(-1, ' ', false, JsonValue::error_handler_t::replace);
}

void set_hints(const std::string& hints, MeshSource& a, MeshSource& b) {
  const JsonValue json = JsonValue::parse(hints, nullptr, false);
  set_hints(json, a);
  set_hints(json, b);
}

}  // namespace meshgauge::server
