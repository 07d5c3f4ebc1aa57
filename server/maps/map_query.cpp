#include "server/maps/map_query.h"

#include "server/http/head_values.h"

namespace meshgauge::server {
namespace {

using api::malformed;
using api::Problem;
using Refusal = std::optional<Problem>;

Refusal read_side(std::string_view value, api::Side& side) {
  if (value != "a" && value != "b") return malformed("'of' must be a or b, not " + quoted(value));
  side = value == "a" ? api::Side::a : api::Side::b;
  return std::nullopt;
}

Refusal read_count(std::string_view value, std::optional<std::size_t>& count) {
  const auto read = whole_number("max_triangles", value, kMostShownTriangles);
  if (const auto* problem = std::get_if<Problem>(&read)) return *problem;
  count = std::get<std::uint64_t>(read);
  return std::nullopt;
}

Refusal read_flag(std::string_view value, bool& flag) {
  if (value != "true" && value != "false") return malformed("'normals' must be true or false, not " + quoted(value));
  flag = value == "true";
  return std::nullopt;
}

}  // namespace

std::string MapQuery::name() const {
  std::string text = of == api::Side::a ? "a" : "b";
  (text += '.') += api::format_of(kind).name;
  if (max_triangles) text += " " + std::to_string(*max_triangles);
  return normals ? text + " normals" : text;
}

std::variant<MapQuery, Problem> parse_map_query(std::string_view query, MapKind kind) {
  MapQuery asked;
  asked.kind = kind;
  std::vector<std::string_view> known{"of", "max_triangles", "normals"};
  if (!is_for_viewing(kind)) {
    if (("&" + std::string(query)).find("&max_triangles") != std::string::npos) {
      return malformed("a ." + std::string(api::format_of(kind).name) +
                       " has the whole mesh: 'max_triangles' is for .glb");
    }
    known = {"of", "normals"};
  }
  const auto refusal = read_query(query, known, [&](std::string_view name, std::string_view value) {
    if (name == "of") return read_side(value, asked.of);
    return name == "normals" ? read_flag(value, asked.normals) : read_count(value, asked.max_triangles);
  });
  if (refusal) return *refusal;
  return asked;
}

}  // namespace meshgauge::server
