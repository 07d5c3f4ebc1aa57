#include "api/formats/gltf_unread.h"

#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "api/formats/gltf_registry.h"

namespace meshgauge::api {
namespace {

using nlohmann::json;

const json& array_of(const json& object, const char* name) {
  static const json kNone = json::array();
  const auto found = object.find(name);
  return found != object.end() && found->is_array() ? *found : kNone;
}

class Counter {
 public:
  explicit Counter(GltfDocument& out) : out_(out) {}

  // Counts the extensions of an object. `objects`: its kind, a plural. Returns true when one of them may hold surface
  // in place of what glTF itself defines.
  bool object(const json& item, std::string_view objects) {
    const auto extensions = item.is_object() ? item.find("extensions") : item.end();
    if (!item.is_object() || extensions == item.end() || !extensions->is_object()) return false;
    bool foreign = false;
    for (const auto& [name, content] : extensions->items()) foreign = extension(name, objects) || foreign;
    return foreign;
  }

  // Counts only materials that displace: any other change of a material leaves the surface where it is.
  void material(const json& item) {
    if (!item.is_object() || !item.contains("extensions") || !item["extensions"].is_object()) return;
    for (const auto& [name, content] : item["extensions"].items()) {
      if (gltf_extension(name).effect == GltfEffect::surface) extension(name, "materials");
    }
  }

  void remark(std::string_view what, std::size_t count) {
    if (count != 0) noted_[std::string(what)] += count;
  }

  void finish() {
    for (const auto& [what, count] : noted_) out_.remarks.push_back(what + ": " + std::to_string(count));
  }

 private:
  bool extension(std::string_view name, std::string_view objects) {
    const GltfExtension known = gltf_extension(name);
    switch (known.effect) {
      case GltfEffect::none:
      case GltfEffect::same:
        return false;
      case GltfEffect::noted:
        remark(known.what, 1);
        return false;
      case GltfEffect::surface:
        out_.unread.add(known.what);
        return true;
      case GltfEffect::read:
        if (known.what == objects) return false;
        break;
      case GltfEffect::unknown:
        break;
    }
    out_.unread.add("extensions " + std::string(name.substr(0, kLongestName)) + " on " + std::string(objects));
    return true;
  }

  static constexpr std::size_t kLongestName = 64;

  GltfDocument& out_;
  std::map<std::string, std::size_t> noted_;
};

}  // namespace

void count_gltf_unread(const json& whole, GltfDocument& out) {
  Counter counter(out);
  const json& meshes = array_of(whole, "meshes");
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    counter.object(meshes[m], "meshes");
    const json& primitives = array_of(meshes[m], "primitives");
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      out.faces[m][p].foreign = counter.object(primitives[p], "primitives");
    }
  }
  for (const json& node : array_of(whole, "nodes")) counter.object(node, "nodes");
  for (const json& material : array_of(whole, "materials")) counter.material(material);
  counter.remark("animations not applied", array_of(whole, "animations").size());
  counter.finish();
}

}  // namespace meshgauge::api
