#include "api/formats/off_binary.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "api/formats/polygons.h"
#include "api/formats/room.h"

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint64_t kWord = 4;
constexpr std::uint64_t kCounts = 3;  // vertices, faces, edges

struct Layout {
  bool big_endian;
  bool counts_colours;
  const char* remark;
};
constexpr Layout kLayouts[] = {
    {true, true, nullptr},
    {false, true, "binary OFF in little-endian byte order, unlike Geomview's"},
    {true, false, "binary OFF without the number of colour components that Geomview writes after each face"},
    {false, false, "binary OFF in little-endian byte order, without the number of colour components after each face"}};

// The body as words of four bytes in one of the layouts.
class Words {
 public:
  Words(const Source& source, const char* body, const Layout& layout, const OffExtras& extras)
      : body_(body),
        count_(static_cast<std::uint64_t>(source.end() - body) / kWord),
        layout_(layout),
        stride_(3 + static_cast<std::uint64_t>(extras.normal + extras.colour + extras.texture)) {
    if (count_ < kCounts) return;
    vertices_ = at(0);
    faces_ = at(1);
  }

  std::uint32_t at(std::uint64_t word) const {
    std::uint32_t value = 0;
    std::memcpy(&value, body_ + word * kWord, kWord);
    return layout_.big_endian ? __builtin_bswap32(value) : value;
  }
  std::uint64_t vertices() const { return vertices_; }
  std::uint64_t faces() const { return faces_; }
  std::uint64_t first_of_vertex(std::uint64_t vertex) const { return kCounts + vertex * stride_; }

  // Returns the word after the face that begins at `word`; nullopt: no face fits there.
  std::optional<std::uint64_t> next_face(std::uint64_t word) const {
    if (word >= count_) return std::nullopt;
    const std::uint64_t corners = at(word);
    std::uint64_t next = word + 1 + corners;
    if (corners == 0 || next > count_) return std::nullopt;
    if (!layout_.counts_colours) return next;
    if (next >= count_) return std::nullopt;
    next += 1 + at(next);
    return next <= count_ ? std::optional(next) : std::nullopt;
  }

  // Returns true when the faces end with the last word and all their indices are in range.
  bool fit() const {
    if (count_ < kCounts || first_of_vertex(vertices_) > count_ || faces_ > count_) return false;
    std::uint64_t word = first_of_vertex(vertices_);
    for (std::uint64_t face = 0; face < faces_; ++face) {
      const auto next = next_face(word);
      if (!next) return false;
      for (std::uint64_t corner = 0; corner < at(word); ++corner) {
        if (at(word + 1 + corner) >= vertices_) return false;
      }
      word = *next;
    }
    return word == count_;
  }

 private:
  const char* body_;
  std::uint64_t count_;
  const Layout& layout_;
  std::uint64_t stride_;
  std::uint64_t vertices_ = 0;
  std::uint64_t faces_ = 0;
};

std::optional<Error> read_vertices(const Source& source, const char* body, const Words& words, ReadMesh& out) {
  reserve_room(out.mesh.positions, words.vertices());
  for (std::uint64_t i = 0; i < words.vertices(); ++i) {
    Vec3 position;
    for (std::uint64_t k = 0; k < 3; ++k) {
      const std::uint64_t word = words.first_of_vertex(i) + k;
      const auto value = std::bit_cast<float>(words.at(word));
      if (!std::isfinite(value)) {
        return at_byte(source, static_cast<std::size_t>(body - source.begin()) + word * kWord,
                       ErrorCode::non_finite_vertex, "a coordinate of vertex " + std::to_string(i) + " is not finite");
      }
      position[static_cast<int>(k)] = static_cast<double>(value);
    }
    out.mesh.positions.push_back(position);
  }
  return std::nullopt;
}

// Precondition: words.fit().
std::optional<Error> read_faces(const Source& source, const Words& words, ReadMesh& out) {
  reserve_room(out.mesh.triangles, words.faces());
  Faces faces(out.mesh.triangles);
  std::uint64_t word = words.first_of_vertex(words.vertices());
  for (std::uint64_t face = 0; face < words.faces(); ++face) {
    faces.begin();
    for (std::uint64_t corner = 0; corner < words.at(word); ++corner) {
      faces.add(words.at(word + 1 + corner));
      if (out.mesh.triangles.size() > source.limits.max_triangles) {
        return too_many(source, "triangles", source.limits.max_triangles);
      }
    }
    out.notes.skipped_primitives += faces.corners() < 3;
    faces.end();
    word = *words.next_face(word);
  }
  if (auto split = split_polygons(source, faces.runs(), out); !split) return std::move(split).error();
  return std::nullopt;
}

}  // namespace

Result<ReadMesh> read_binary_off(const Source& source, const char* body, const OffExtras& extras) {
  const bool whole_words = static_cast<std::uint64_t>(source.end() - body) % kWord == 0;
  for (const Layout& layout : kLayouts) {
    const Words words(source, body, layout, extras);
    if (!whole_words || !words.fit()) continue;
    if (words.vertices() > vertex_limit(source)) return too_many(source, "vertices", vertex_limit(source));
    ReadMesh out;
    out.format = Format::off;
    if (auto error = read_vertices(source, body, words, out)) return std::move(*error);
    if (auto error = read_faces(source, words, out)) return std::move(*error);
    if (layout.remark != nullptr) out.notes.remarks.emplace_back(layout.remark);
    return out;
  }
  return at_byte(
      source, static_cast<std::size_t>(body - source.begin()), ErrorCode::unreadable_mesh,
      "truncated or damaged: the counts and faces of this binary OFF do not end where the file ends, in either "
      "byte order");
}

}  // namespace meshgauge::api
