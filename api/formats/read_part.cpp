#include "api/formats/read_part.h"

#include <bit>
#include <chrono>
#include <cstdint>
#include <limits>
#include <new>
#include <vector>

#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

// Mixes a word into a hash so that every bit of it reaches the high half (the multiply-and-fold of wyhash).
__extension__ using Wide = unsigned __int128;
std::uint64_t mix(std::uint64_t hash, std::uint64_t word) {
  const Wide product = static_cast<Wide>(hash ^ word) * 0x9E3779B97F4A7C15U;
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64U);
}

// Open addressing over the positions kept so far; the table holds their indices.
class Positions {
 public:
  explicit Positions(std::size_t count)
      : mask_(std::bit_ceil(2 * count + 1) - 1), table_(mask_ + 1, kFree), seed_(unforeseen()) {}

  // Returns the index of p in `kept`; appends a new position.
  std::uint32_t index_of(const Vec3& p, Vec3* kept, std::uint32_t& kept_count) {
    for (std::size_t slot = hash(p) & mask_;; slot = (slot + 1) & mask_) {
      if (table_[slot] == kFree) {
        kept[kept_count] = p;
        return table_[slot] = kept_count++;
      }
      if (kept[table_[slot]] == p) return table_[slot];
    }
  }

 private:
  static constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();

  // Returns a different seed each time, so that no file can be crafted whose positions all collide. The result of
  // weld() does not depend on it.
  std::uint64_t unforeseen() const {
    const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
    return mix(static_cast<std::uint64_t>(now), reinterpret_cast<std::uintptr_t>(table_.data()));
  }

  std::size_t hash(const Vec3& p) const {
    std::uint64_t h = seed_;
    for (int k = 0; k < 3; ++k) h = mix(h, std::bit_cast<std::uint64_t>(p[k]));
    return h;
  }

  std::size_t mask_;
  std::vector<std::uint32_t> table_;
  std::uint64_t seed_;
};

}  // namespace

std::size_t weld(Mesh& mesh) {
  const std::size_t before = mesh.positions.size();
  Positions known(before);
  std::vector<std::uint32_t> welded(before);
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < before; ++i) {
    const Vec3 p = mesh.positions[i].array() + 0.0;              // -0.0 + 0.0 is 0.0; every other number is unchanged
    welded[i] = known.index_of(p, mesh.positions.data(), kept);  // kept <= i: in place
  }
  mesh.positions.resize(kept);
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& index : triangle) index = welded[index];
  }
  return before - kept;
}

Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits) {
  auto read = read_mesh(bytes, hints, limits);
  if (!read) return read;
  try {
    // Formats without indices repeat every corner; merged vertices save the engine most of its queries.
    const bool repeats_corners = read->mesh.positions.size() == 3 * read->mesh.triangles.size();
    if (repeats_corners) read->notes.welded_vertices = weld(read->mesh);
  } catch (const std::bad_alloc&) {
    return out_of_memory(hints.part);
  }
  return read;
}

}  // namespace meshgauge::api
