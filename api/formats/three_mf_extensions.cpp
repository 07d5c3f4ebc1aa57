#include "api/formats/three_mf_extensions.h"

#include <algorithm>

#include "api/formats/text.h"
#include "api/formats/three_mf_attributes.h"

namespace meshgauge::api {
namespace {

constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
// The namespaces that are read or do not affect the surface.
constexpr std::string_view kUnderstood[] = {kCore, kMfProduction,
                                            "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
                                            "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07",
                                            "http://software.ultimaker.com/xml/cura/3mf/2015/10"};
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
                             {"displacement", "displaced surfaces"}, {"alternatives", "alternative objects"}};

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

bool is_mf_core(const XmlName& name, std::string_view local) { return name.is(kCore, local); }

bool is_mf_core(const XmlName& name) { return name.space == kCore; }

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

MfOrigin origin_of(const XmlName& name) {
  if (is_understood(name.space)) return MfOrigin::understood;
  return is_standard(name.space) ? MfOrigin::standard : MfOrigin::other;
}

XmlDefect unsupported_mf_geometry(const XmlName& element) {
  return unsupported("geometry of the extension", element.space);
}

std::optional<XmlDefect> check_mf_attributes(const XmlAttributes& attributes) {
  constexpr std::string_view kCoreAttributes[] = {
      "unit", "requiredextensions", "type", "objectid", "transform", "printable", "v1", "v2", "v3", "x", "y", "z"};
  for (const auto& [name, value] : attributes.prefixed()) {
    const bool is_ours = name.space.empty() || name.space == kCore;
    if (is_ours && std::ranges::find(kCoreAttributes, name.local) != std::end(kCoreAttributes)) {
      return malformed_xml("the attribute " + in_quotes(name.written) + " has a prefix; 3MF writes " +
                           in_quotes(name.local) + " without one");
    }
    if (name.space.empty() && name.local == "path") {
      return malformed_xml("the attribute " + in_quotes(name.written) +
                           " names another part, but its prefix is not declared");
    }
    const bool is_resolution = name.local == "meshresolution" || name.local == "modelresolution";
    if (is_resolution && origin_of(name) == MfOrigin::standard && value != std::string_view("fullres")) {
      return XmlDefect{
          ErrorCode::unsupported_format,
          "the attribute " + in_quotes(name.written) + " is " + in_quotes(value) +
              ": the surface is in an extension that is not supported; save the object at full resolution"};
    }
  }
  return std::nullopt;
}

std::optional<XmlDefect> check_mf_spelling(const XmlAttributes& attributes,
                                           std::initializer_list<std::string_view> known) {
  for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
    for (const std::string_view name : known) {
      if (name == pair[0] || !same_word(pair[0], name)) continue;
      return malformed_xml("the attribute " + in_quotes(pair[0]) + " is unknown; 3MF spells it " + in_quotes(name));
    }
  }
  return std::nullopt;
}

}  // namespace meshgauge::api
