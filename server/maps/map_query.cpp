#include "server/maps/map_query.h"

#include <charconv>

#include "api/refused.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::malformed;
using api::Problem;
using Refusal = std::optional<Problem>;

// A client's text, quoted for a message.
std::string quoted(std::string_view text) { return "'" + std::string(text.substr(0, 40)) + "'"; }

Refusal read_side(std::string_view value, api::Side& side) {
  if (value != "a" && value != "b") return malformed("'of' must be a or b, not " + quoted(value));
  side = value == "a" ? api::Side::a : api::Side::b;
  return std::nullopt;
}

Refusal read_count(std::string_view value, std::optional<std::size_t>& count) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  const bool whole = error == std::errc() && end == value.data() + value.size() && is_digit(value.front());
  if (!whole || number < 1 || number > kMostShownTriangles) {
    return malformed("'max_triangles' must be a whole number from 1 to " + std::to_string(kMostShownTriangles) +
                     ", not " + quoted(value));
  }
  count = number;
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
  bool side_given = false, normals_given = false;
  while (!query.empty()) {
    std::string_view value = next(query, "&");
    const std::string_view name = next(value, "=");
    Refusal refusal;
    if (name == "of" && !std::exchange(side_given, true)) {
      refusal = read_side(value, asked.of);
    } else if (name == "max_triangles" && is_for_viewing(kind) && !asked.max_triangles) {
      refusal = read_count(value, asked.max_triangles);
    } else if (name == "normals" && !std::exchange(normals_given, true)) {
      refusal = read_flag(value, asked.normals);
    } else if (name == "max_triangles" && !is_for_viewing(kind)) {
      refusal = malformed("a ." + std::string(api::format_of(kind).name) +
                          " has the whole mesh: 'max_triangles' is for .glb");
    } else if (name == "of" || name == "max_triangles" || name == "normals") {
      refusal = malformed("'" + std::string(name) + "' stands there twice");
    } else {
      refusal = malformed("unknown query parameter " + quoted(name) + "; known: of" +
                          (is_for_viewing(kind) ? ", max_triangles" : "") + ", normals");
    }
    if (refusal) return *refusal;
  }
  return asked;
}

}  // namespace meshgauge::server
