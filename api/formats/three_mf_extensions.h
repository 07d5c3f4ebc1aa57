// The extensions of 3MF that are understood; others are refused if they matter.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/xml.h"

namespace meshgauge::api {

using MfPrefixes = std::map<std::string, std::string, std::less<>>;  // prefix -> namespace

// Returns true for the core element of the local name `local`.
bool is_mf_core(std::string_view name, std::string_view local);

// Name of the production extension's attribute that names another part.
inline constexpr std::string_view kMfPathAttribute =
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06\npath";

// Refuses by name a required extension other than production, materials and triangle sets, which are understood.
std::optional<XmlDefect> check_mf_extensions(std::string_view required_prefixes, const MfPrefixes& prefixes);

// Refuses an element inside an object or a mesh when it is of an extension of the standard that is not understood:
// there extensions put geometry (beams, volumes, booleans, ...). Elements of vendors' own namespaces are not geometry.
std::optional<XmlDefect> refuse_mf_geometry(std::string_view element);

}  // namespace meshgauge::api
