// Facets of any floats, written as binary and as ASCII STL, are read back exactly, by us and by libadmesh.
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "api/formats/format.h"
#include "tests/api/formats/admesh_peer.h"
#include "tests/api/formats/files.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using api::test::Facet;
using api::test::raw;

constexpr std::size_t kMostFacets = 64;
constexpr std::size_t kFewestFacets = 4;  // libadmesh takes none for a binary file that has fewer

std::vector<Facet> facets_of(const std::uint8_t* data, std::size_t size) {
  std::vector<Facet> facets;
  for (; size >= sizeof(Facet) && facets.size() < kMostFacets; data += sizeof(Facet), size -= sizeof(Facet)) {
    Facet& facet = facets.emplace_back();
    std::memcpy(facet.data(), data, sizeof(Facet));
    for (float& c : facet) c = std::isfinite(c) ? c : 1.F;
  }
  while (facets.size() < kFewestFacets) facets.push_back({0, 0, 0, 1, 0, 0, 0, 1, 0});
  return facets;
}

std::string binary(const std::vector<Facet>& facets) {
  std::string out = std::string(80, 's') + raw(static_cast<std::uint32_t>(facets.size()));
  for (const Facet& facet : facets) {
    for (const float n : {-1.F, 0.F, 0.F}) out += raw(n);
    for (const float c : facet) out += raw(c);
    out += std::string(2, '\0');
  }
  return out;
}

std::string ascii(const std::vector<Facet>& facets) {
  std::string out = "solid s\n";
  for (const Facet& facet : facets) {
    out += "facet normal -1 0 0\nouter loop";
    for (std::size_t k = 0; k < facet.size(); ++k) {
      char number[32];
      std::snprintf(number, sizeof number, k % 3 == 0 ? "\nvertex %.9g" : " %.9g", static_cast<double>(facet[k]));
      out += number;
    }
    out += "\nendloop\nendfacet\n";
  }
  return out + "endsolid s\n";
}

std::vector<Facet> by_us(const std::string& file) {
  const auto read = api::test::read(file, "m.stl");
  require(read.ok(), "a good file is read", read ? "" : read.error().message);
  std::vector<Facet> facets(read->mesh.triangles.size());
  for (std::size_t i = 0; i < 9 * facets.size(); ++i) {
    facets[i / 9][i % 9] = static_cast<float>(read->mesh.positions.at(i / 3)[static_cast<int>(i % 3)]);
  }
  return facets;
}

bool same_bits(const std::vector<Facet>& a, const std::vector<Facet>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Facet)) == 0;
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(stl_admesh) {
  using namespace meshgauge::fuzz;
  const auto facets = facets_of(data, size);
  for (const std::string& file : {binary(facets), ascii(facets)}) {
    require(same_bits(by_us(file), facets), "we read what was written", file);
    const auto theirs = meshgauge::api::test::by_admesh(file);
    require(theirs && same_bits(*theirs, facets), "libadmesh reads what was written", file);
  }
  return 0;
}
