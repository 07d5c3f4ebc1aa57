// The extensions of 3MF that are understood; others are refused if they matter.
#pragma once

#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/xml.h"

namespace meshgauge::api {

using MfPrefixes = std::map<std::string, std::string, std::less<>>;  // prefix -> namespace

// Returns true for the core element of the local name `local`.
bool is_mf_core(const XmlName& name, std::string_view local);
// Returns true for any element of the core namespace.
bool is_mf_core(const XmlName& name);

// The namespace of the production extension, whose attribute `path` names another part.
inline constexpr std::string_view kMfProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";

// Refuses by name a required extension other than production, materials and triangle sets, which are understood.
std::optional<XmlDefect> check_mf_extensions(std::string_view required_prefixes, const MfPrefixes& prefixes);

// What an element or an attribute in an object, a mesh or the build may be. Understood: of an extension that is read or
// has no effect on the surface. Standard: of another extension of the standard; those put geometry there (beams,
// volumes, booleans, slices). Other: of a vendor, or with a prefix that is not declared.
enum class MfOrigin { understood, standard, other };
MfOrigin origin_of(const XmlName& name);

// Returns the refusal of such a standard element.
XmlDefect unsupported_mf_geometry(const XmlName& element);

// Refuses attributes of an element with geometry that say that the surface is elsewhere: a mesh of low resolution
// beside slices or alternatives, a path whose prefix is not declared, and attributes of 3MF itself with a prefix, which
// others may read.
std::optional<XmlDefect> check_mf_attributes(const XmlAttributes& attributes);

// Refuses an attribute that differs from one of `known` only by upper and lower case.
std::optional<XmlDefect> check_mf_spelling(const XmlAttributes& attributes,
                                           std::initializer_list<std::string_view> known);

}  // namespace meshgauge::api
