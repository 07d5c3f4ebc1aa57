// libadmesh as a peer of our STL reader. It is licensed under the GPL: used by tests only, never part of the product.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::api::test {

using Facet = std::array<float, 9>;  // three corners

// Returns the facets as libadmesh reads them, in the order of the file; nullopt: it refuses the file.
std::optional<std::vector<Facet>> by_admesh(std::string_view file);

// In words, why libadmesh may see other facets in a file of `facets` than a reader of the format; empty when it must
// see the same. Each is a limit of its own, found in its version 0.98.4.
std::string_view admesh_excuse(std::string_view file, std::size_t facets);

}  // namespace meshgauge::api::test
