#include "api/formats/gltf_extensions.h"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "api/formats/gltf_registry.h"

namespace meshgauge::api {
namespace {

using nlohmann::json;

constexpr std::string_view kMeshoptNames[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

Result<Done> check_required(const Source& source, const json& root, GltfDocument& out) {
  const auto names = [&](const char* key) { return root.value(key, std::vector<std::string>()); };
  for (const std::string& extension : names("extensionsRequired")) {
    if (may_be_required(gltf_extension(extension))) continue;
    return at(source, "extensionsRequired", ErrorCode::unsupported_format,
              "the extension " + in_quotes(extension) + " is not supported; save the model without it");
  }
  for (const char* key : {"extensionsRequired", "extensionsUsed"}) {
    out.quantized = out.quantized || std::ranges::count(names(key), "KHR_mesh_quantization") > 0;
  }
  return Done{};
}

std::optional<std::size_t> index_of(const json& object, const char* name) {
  const auto found = object.find(name);
  if (found == object.end()) return std::nullopt;
  return found->get<std::size_t>();
}

// Returns the extension of an object; nullptr: it has none of this name.
const json* extension_of(const json& object, std::string_view name) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end()) return nullptr;
  const auto found = extensions->find(name);
  return found == extensions->end() ? nullptr : &*found;
}

GltfFaces faces_of(const json& primitive) {
  GltfFaces out;
  out.indices = index_of(primitive, "indices");
  if (const json* draco = extension_of(primitive, "KHR_draco_mesh_compression")) {
    out.draco.emplace();
    out.draco->view = (*draco)["bufferView"].get<std::size_t>();
    for (const auto& [name, id] : (*draco)["attributes"].items()) out.draco->ids[name] = id.get<std::uint32_t>();
  }
  return out;
}

GltfMeshopt meshopt_of(const json& extension) {
  GltfMeshopt out;
  out.buffer = extension["buffer"].get<std::size_t>();
  out.offset = extension.value("byteOffset", std::size_t{0});
  out.length = extension["byteLength"].get<std::size_t>();
  out.stride = extension["byteStride"].get<std::size_t>();
  out.count = extension["count"].get<std::size_t>();
  out.mode = extension["mode"].get<std::string>();
  out.filter = extension.value("filter", "NONE");
  return out;
}

void take_faces(json& root, GltfDocument& out) {
  for (json& mesh : root["meshes"]) {
    auto& faces = out.faces.emplace_back();
    for (json& primitive : mesh["primitives"]) {
      faces.push_back(faces_of(primitive));
      primitive.erase("indices");
      primitive.erase("extensions");
    }
  }
}

// Refuses a view with both extensions of meshopt: each forbids the other, and the choice would be arbitrary.
Result<Done> take_views(const Source& source, json& views, GltfDocument& out) {
  for (std::size_t i = 0; i < views.size(); ++i) {
    for (const std::string_view name : kMeshoptNames) {
      const json* found = extension_of(views[i], name);
      if (found == nullptr) continue;
      if (out.meshopt.contains(i)) {
        return at(source, "bufferViews[" + std::to_string(i) + "].extensions", ErrorCode::unreadable_mesh,
                  "has EXT_meshopt_compression and KHR_meshopt_compression; save the model with one of them");
      }
      out.meshopt[i] = meshopt_of(*found);
    }
    out.strides.push_back(index_of(views[i], "byteStride"));
    views[i].erase("byteStride");
    views[i].erase("extensions");
  }
  return Done{};
}

void take_node_extensions(json& nodes, GltfDocument& out) {
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (const json* found = extension_of(nodes[i], "EXT_mesh_gpu_instancing")) {
      const json& attributes = (*found)["attributes"];
      out.instancing[i] = {index_of(attributes, "TRANSLATION"), index_of(attributes, "ROTATION"),
                           index_of(attributes, "SCALE")};
    }
    const json* visibility = extension_of(nodes[i], "KHR_node_visibility");
    if (visibility != nullptr && !visibility->value("visible", true)) out.hidden.insert(i);
    nodes[i].erase("extensions");
  }
}

}  // namespace

Result<Done> take_gltf_extensions(const Source& source, json& root, GltfDocument& out) {
  if (auto ok = check_required(source, root, out); !ok) return ok;
  if (root.contains("meshes")) take_faces(root, out);
  if (root.contains("bufferViews")) {
    if (auto ok = take_views(source, root["bufferViews"], out); !ok) return ok;
  }
  if (root.contains("nodes")) take_node_extensions(root["nodes"], out);
  for (const char* done : {"extensionsUsed", "extensionsRequired"}) root.erase(done);
  return Done{};
}

bool is_gltf_fallback(const json& buffer) {
  return std::ranges::any_of(kMeshoptNames, [&](std::string_view name) {
    const json* found = extension_of(buffer, name);
    return found != nullptr && found->value("fallback", false);
  });
}

}  // namespace meshgauge::api
