#include "cli/mcp/tool.h"

#include <openssl/evp.h>

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "api/base/text.h"
#include "api/base/utf8.h"

namespace meshgauge::mcp {
namespace {

constexpr std::size_t kMostNameBytes = 255;

std::string pointer_itself(std::string_view pointer) {
  return pointer.empty() ? "the arguments" : std::string(pointer);
}

// nullopt: no base64, that of RFC 4648 with its padding.
std::optional<std::vector<std::byte>> decoded(std::string_view text) {
  const std::size_t padding = text.ends_with("==") ? 2U : text.ends_with('=') ? 1U : 0U;
  if (text.size() % 4 != 0 || text.find('=') < text.size() - padding) return std::nullopt;
  std::vector<std::byte> bytes(text.size() / 4 * 3);
  const int length =
      EVP_DecodeBlock(reinterpret_cast<unsigned char*>(bytes.data()),
                      reinterpret_cast<const unsigned char*>(text.data()), static_cast<int>(text.size()));
  if (length < 0 || static_cast<std::size_t>(length) != bytes.size()) return std::nullopt;
  bytes.resize(bytes.size() - padding);
  return bytes;
}

// Programs that write base64 break its lines.
std::string without_spaces(std::string text) {
  std::erase_if(text, api::is_space);
  return text;
}

void read_base64(const nlohmann::json& value, const std::string& at, api::Reading& reading, MeshArgument& mesh) {
  if (!value.is_string()) return reading.refuse(at, "must be a text, not " + reading.shown(value));
  const std::string text = without_spaces(value.get_ref<const std::string&>());
  if (text.size() / 4 * 3 > kMostInlineBytes + 2)  // 2: the padding
    return reading.refuse(at, "has more than " + std::to_string(kMostInlineBytes) +
                                  " bytes: write the mesh to a file below a root, and give its path");
  auto bytes = decoded(text);
  if (!bytes) return reading.refuse(at, "must be base64 (RFC 4648): it is not");
  mesh.bytes = *std::move(bytes);
}

void read_path(const nlohmann::json& value, const std::string& at, api::Reading& reading, MeshArgument& mesh) {
  mesh.path = reading.text(value, at).value_or("");
  if (value.is_string() && mesh.path.empty()) reading.refuse(at, "is empty: name a file");
}

void read_mesh_name(const nlohmann::json& value, const std::string& at, api::Reading& reading, MeshArgument& mesh) {
  const auto name = reading.text(value, at);
  if (!name) return;
  if (name->size() > kMostNameBytes || find_control(*name) != std::string::npos)
    return reading.refuse(at, "must be the name of a file, of at most " + std::to_string(kMostNameBytes) +
                                  " bytes without control characters");
  mesh.name = *name;
}

}  // namespace

constinit const api::Surface kArguments{
    api::Surface::python, pointer_itself, "argument", "an object", "an array", "null", "a", "b", "a_to_b", "b_to_a"};

void put_first(Json& criteria, const Json& name) {
  auto& all = criteria.get_ref<Json::array_t&>();
  const auto first = std::ranges::find_if(all, [&](const Json& one) { return one.at("name") == name; });
  if (first != all.end()) std::rotate(all.begin(), first, std::next(first));
}

ToolAnswer failure(const Error& error) {
  std::string text = error.message;
  for (const Error& other : error.others) text += "\n" + other.message;
  return {std::move(text), nullptr, {}};
}

ToolAnswer failure(const std::vector<api::RequestMistake>& mistakes) {
  std::string text;
  for (const api::RequestMistake& mistake : mistakes) {
    const bool says_where = mistake.pointer.empty() || mistake.message.starts_with(mistake.pointer);
    text += (text.empty() ? "" : "\n") + (says_where ? "" : mistake.pointer + ": ") + mistake.message;
  }
  return {std::move(text), nullptr, {}};
}

Json object_schema(Json properties, const std::vector<std::string>& required) {
  Json schema{{"type", "object"}, {"properties", std::move(properties)}, {"additionalProperties", false}};
  if (!required.empty()) schema["required"] = required;
  return schema;
}

Json schema_of(const Json& type, std::string_view description) {
  return {{"type", type}, {"description", description}};
}

Json mesh_schema(std::string_view description) {
  Json schema =
      object_schema({{"path", schema_of("string",
                                        "A file below a root: absolute, or relative to the root. No '..', no symbolic "
                                        "links. OBJ, STL, PLY, OFF, glTF, GLB, 3MF or XYZ, also gzip-compressed")},
                     {"base64", schema_of("string", "In place of a path: the file's bytes, as base64")},
                     {"name", schema_of("string", "Beside base64: the file's name, such as part.stl")}},
                    {});
  schema["description"] = description;
  return schema;
}

MeshArgument read_mesh_argument(const nlohmann::json& value, const std::string& at, api::Reading& reading) {
  MeshArgument mesh;
  const api::Reading::Member members[] = {
      {"path", [&](const auto& v, const std::string& place) { read_path(v, place, reading, mesh); }},
      {"base64", [&](const auto& v, const std::string& place) { read_base64(v, place, reading, mesh); }},
      {"name", [&](const auto& v, const std::string& place) { read_mesh_name(v, place, reading, mesh); }}};
  if (!reading.members(value, members, at)) return mesh;
  if (value.contains("path") == value.contains("base64")) reading.refuse(at, "must have a path or base64, one of both");
  if (value.contains("path") && value.contains("name"))
    reading.refuse(at + "/name", "goes with base64: a path has a name already");
  return mesh;
}

Result<GivenMesh> GivenMesh::open(MeshArgument argument, const std::string& part, const api::Confines& confines) {
  GivenMesh mesh;
  if (argument.path.empty()) {
    mesh.name_ = argument.name.empty() ? part : argument.name;
    mesh.filename_ = std::move(argument.name);
    mesh.bytes_ = std::move(argument.bytes);
    return Result<GivenMesh>(std::move(mesh));
  }
  auto file = api::MeshFile::open_within(confines, argument.path);
  if (!file) return std::move(file).error();
  mesh.name_ = mesh.filename_ = std::move(argument.path);
  mesh.file_ = std::move(*file);
  return Result<GivenMesh>(std::move(mesh));
}

api::MeshInput GivenMesh::input() const {
  return {name_, file_ ? file_->bytes() : std::span<const std::byte>(bytes_), filename_, ""};
}

}  // namespace meshgauge::mcp
