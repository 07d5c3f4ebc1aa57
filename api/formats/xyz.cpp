#include "api/formats/xyz.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "api/formats/room.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

// Returns the point at p. An Error names the line.
Result<Vec3> point_at(const Source& source, const char* p) {
  Vec3 point;
  for (int k = 0; k < 3; ++k) {
    p = skip_blanks(p, source.end());
    const std::string_view word = word_at(p, source.end());
    if (word.empty() || word.front() == '#') {
      return at_line(source, p, ErrorCode::unreadable_mesh, "a point needs three coordinates");
    }
    p = parse_number(p, source.end(), point[k]);
    if (p != word.data() + word.size()) {
      return at_line(source, word.data(), ErrorCode::unreadable_mesh, in_quotes(word) + " is not a number");
    }
    if (std::isfinite(point[k])) continue;
    return at_line(source, word.data(), ErrorCode::non_finite_vertex,
                   "the coordinate " + in_quotes(word) + " is not finite");
  }
  return point;
}

}  // namespace

Result<ReadMesh> read_xyz(const Source& source) {
  constexpr std::size_t kUsualLine = 24;  // bytes of a point
  const std::size_t limit = vertex_limit(source);
  ReadMesh out;
  out.format = Format::xyz;
  reserve_room(out.mesh.positions, std::min(source.bytes.size() / kUsualLine, limit));
  const char* const end = source.end();
  const char* p = source.begin() + (source.text().starts_with("\xEF\xBB\xBF") ? 3 : 0);
  for (p = skip_spaces(p, end); p != end; p = skip_spaces(p, end)) {
    const char* const line = p;
    p = skip_line(p, end);
    if (const char* const nul = std::find(line, p, '\0'); nul != p) {
      return at_line(source, nul, ErrorCode::unreadable_mesh, "binary data in a text file");
    }
    if (*line == '#') continue;
    if (out.mesh.positions.size() == limit) return too_many(source, "points", limit);
    const auto point = point_at(source, line);
    if (!point) return point.error();
    out.mesh.positions.push_back(*point);
  }
  if (out.mesh.positions.empty()) return about(source.part, ErrorCode::empty_mesh, "has no points");
  if (auto ok = make_cloud(source, out); !ok) return std::move(ok).error();
  return out;
}

}  // namespace meshgauge::api
