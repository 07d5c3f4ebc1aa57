#include "api/formats/three_mf_extensions.h"

#include <algorithm>

#include "api/formats/text.h"
#include "api/formats/three_mf_attributes.h"

namespace meshgauge::api {
namespace {

constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
// The namespaces that are read or do not affect the surface.
constexpr std::string_view kUnderstood[] = {kCore, "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
                                            "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
                                            "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07"};
// Prefixes of the standard's namespaces; others are metadata of some program.
constexpr std::string_view kStandards[] = {"http://schemas.microsoft.com/3dmanufacturing/",
                                           "http://schemas.3mf.io/3dmanufacturing/"};

// Describes an unsupported extension by a part of its namespace's name.
struct Topic {
  std::string_view part_of_name;
  std::string_view what;
};
constexpr Topic kTopics[] = {{"beamlattice", "a beam lattice"},      {"slice", "slices"},
                             {"securecontent", "encrypted content"}, {"booleanoperations", "boolean operations"},
                             {"volumetric", "volumetric content"},   {"implicit", "implicit surfaces"},
                             {"displacement", "displaced surfaces"}};

bool is_understood(std::string_view name_space) {
  return std::ranges::find(kUnderstood, name_space) != std::end(kUnderstood);
}

bool is_standard(std::string_view name_space) {
  return std::ranges::any_of(kStandards, [&](std::string_view start) { return name_space.starts_with(start); });
}

XmlDefect unsupported(const std::string& what, std::string_view name_space) {
  std::string topic;
  for (const Topic& known : kTopics) {
    if (topic.empty() && name_space.find(known.part_of_name) != std::string_view::npos) {
      topic = " (" + std::string(known.what) + ")";
    }
  }
  return {ErrorCode::unsupported_format,
          what + " '" + printable(name_space, 100) + "'" + topic + ", which is not supported"};
}

}  // namespace

bool is_mf_core(std::string_view name, std::string_view local) {
  return name.size() == kCore.size() + 1 + local.size() && name.ends_with(local) && name.starts_with(kCore) &&
         name[kCore.size()] == kXmlSeparator;
}

std::optional<XmlDefect> check_mf_extensions(std::string_view required_prefixes, const MfPrefixes& prefixes) {
  const char* const end = required_prefixes.data() + required_prefixes.size();
  for (const char* p = skip_spaces(required_prefixes.data(), end); p != end; p = skip_spaces(p, end)) {
    const std::string_view prefix = word_at(p, end);
    p += prefix.size();
    const auto known = prefixes.find(prefix);
    if (known == prefixes.end())
      return malformed_xml("the required extension " + in_quotes(prefix) + " is not declared");
    if (!is_understood(known->second)) return unsupported("it requires the extension", known->second);
  }
  return std::nullopt;
}

std::optional<XmlDefect> refuse_mf_geometry(std::string_view element) {
  const std::string_view name_space = element.substr(0, std::min(element.find(kXmlSeparator), element.size()));
  if (!is_standard(name_space) || is_understood(name_space)) return std::nullopt;
  return unsupported("geometry of the extension", name_space);
}

}  // namespace meshgauge::api
