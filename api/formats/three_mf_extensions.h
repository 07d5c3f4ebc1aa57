// Which extensions of 3MF are understood, and what becomes of the others.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/xml.h"

namespace meshgauge::api {

using MfPrefixes = std::map<std::string, std::string, std::less<>>;  // and the namespaces that they stand for

// True for an element of the core of the standard.
bool is_mf_core(std::string_view name, std::string_view local);

// The attribute of the production extension that names another part.
inline constexpr std::string_view kMfPathAttribute =
    "http://schemas.microsoft.com/3dmanufacturing/production/2015/06\npath";

// Understood are production, materials and triangle sets; any other that a model requires is refused by name.
std::optional<XmlDefect> check_mf_extensions(std::string_view required_prefixes, const MfPrefixes& prefixes);

// Of an element inside of an object or a mesh, where the standard's extensions (beams, volumes, booleans, ...) put
// geometry: refuses those that are not understood. Elements of other makers are nobody's geometry.
std::optional<XmlDefect> refuse_mf_geometry(std::string_view element);

}  // namespace meshgauge::api
