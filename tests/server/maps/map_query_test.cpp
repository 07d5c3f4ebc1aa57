#include "server/maps/map_query.h"

#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::MapKind;
using server::MapQuery;
using server::parse_map_query;

namespace {

std::string name_of(std::string_view query, MapKind kind) {
  const auto asked = parse_map_query(query, kind);
  REQUIRE(std::holds_alternative<MapQuery>(asked));
  return std::get<MapQuery>(asked).name();
}

std::string refusal_of(std::string_view query, MapKind kind = MapKind::glb) {
  const auto asked = parse_map_query(query, kind);
  REQUIRE(std::holds_alternative<api::Problem>(asked));
  CHECK(std::get<api::Problem>(asked).status() == 400);
  return std::get<api::Problem>(asked).detail;
}

bool says(const std::string& text, const std::string& what) { return text.find(what) != std::string::npos; }

}  // namespace

TEST_CASE("map query: each map has a name") {
  CHECK(name_of("", MapKind::ply) == "a.ply");
  CHECK(name_of("of=a", MapKind::ply) == "a.ply");
  CHECK(name_of("of=b", MapKind::glb) == "b.glb");
  CHECK(name_of("of=b", MapKind::vtp) == "b.vtp");
  CHECK(name_of("", MapKind::csv) == "a.csv");
  CHECK(name_of("max_triangles=20000", MapKind::glb) == "a.glb 20000");
  CHECK(name_of("max_triangles=1&of=b", MapKind::glb) == "b.glb 1");
  CHECK(name_of("normals=false", MapKind::csv) == "a.csv");
  CHECK(name_of("normals=true&of=b", MapKind::ply) == "b.ply normals");
  CHECK(name_of("normals=true&max_triangles=9", MapKind::glb) == "a.glb 9 normals");
  CHECK(name_of("max_triangles=1073741824", MapKind::glb) == "a.glb 1073741824");
}

TEST_CASE("map query: errors name the parameter") {
  CHECK(says(refusal_of("of=A"), "'of' must be a or b, not 'A'"));
  CHECK(says(refusal_of("of"), "'of' must be a or b, not ''"));
  CHECK(says(refusal_of("of=a&of=a"), "'of' stands there twice"));
  CHECK(says(refusal_of("max_triangles=1&max_triangles=1"), "twice"));
  CHECK(says(refusal_of("max_triangles=1", MapKind::ply), "a .ply has the whole mesh: 'max_triangles' is for .glb"));
  CHECK(says(refusal_of("max_triangles=1", MapKind::csv), "a .csv has the whole mesh"));
  CHECK(says(refusal_of("x=1"), "unknown query parameter 'x'; known: of, max_triangles, normals"));
  CHECK(says(refusal_of("x=1", MapKind::ply), "known: of, normals"));
  CHECK(says(refusal_of("normals"), "'normals' must be true or false, not ''"));
  CHECK(says(refusal_of("normals=false&normals=true"), "'normals' stands there twice"));
  CHECK(says(refusal_of("&"), "unknown query parameter ''"));
  CHECK(refusal_of(std::string(2000, 'x')).size() < 200);
  for (const char* value :
       {"", "0", "-1", "+1", "1.0", "1e3", " 1", "1 ", "0x1", "1073741825", "99999999999999999999"}) {
    CHECK(says(refusal_of(std::string("max_triangles=") + value), "whole number from 1 to 1073741824"));
  }
}
