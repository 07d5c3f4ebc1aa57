#include "api/formats/weld.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <limits>
#include <vector>

namespace meshgauge::api {
namespace {

constexpr std::uint32_t kFree = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBlock = 64;  // positions whose places in memory are fetched together

// Mixes two words so that every bit of both reaches every bit (the multiply-and-fold of wyhash).
__extension__ using Wide = unsigned __int128;
std::uint64_t mix(std::uint64_t a, std::uint64_t b) {
  const Wide product = static_cast<Wide>(a) * b;
  return static_cast<std::uint64_t>(product) ^ static_cast<std::uint64_t>(product >> 64U);
}
constexpr std::uint64_t kFactor = 0x9E3779B97F4A7C15U;

// Returns the bits of a coordinate. -0.0 + 0.0 is 0.0; every other number is unchanged.
std::uint64_t bits_of(double x) { return std::bit_cast<std::uint64_t>(x + 0.0); }

}  // namespace

// The seed is different each time, so that no file can be crafted whose positions all collide. No result depends on it.
Welder::Welder(Vec3* kept, std::size_t expected) : kept_(kept) {
  make_table(std::bit_ceil(2 * expected + 1));
  const auto now = std::chrono::steady_clock::now().time_since_epoch().count();
  seed_ = mix(static_cast<std::uint64_t>(now) ^ kFactor, reinterpret_cast<std::uintptr_t>(table_.data()) ^ kFactor);
}

std::uint64_t Welder::hash(const Vec3& p) const {
  const std::uint64_t of_two = mix(bits_of(p[0]) ^ seed_, bits_of(p[1]) ^ (seed_ * kFactor));
  return mix(of_two ^ bits_of(p[2]), kFactor);
}

void Welder::make_table(std::size_t slots) {
  table_.clear();
  table_.resize(slots);
  std::ranges::fill(table_, kFree);
}

void Welder::grow() {
  const std::size_t slots = 2 * table_.size();
  table_ = decltype(table_)();  // frees its memory before the larger one is taken
  make_table(slots);
  const std::size_t mask = slots - 1;
  for (std::uint32_t i = 0; i < count_; ++i) {
    std::size_t slot = hash(kept_[i]) & mask;
    while (table_.data()[slot] != kFree) slot = (slot + 1) & mask;
    table_.data()[slot] = i;
  }
}

std::uint32_t Welder::index_of(const Vec3& p, std::uint64_t hash) {
  std::uint32_t* const table = table_.data();
  const std::size_t mask = table_.size() - 1;
  for (std::size_t slot = hash & mask;; slot = (slot + 1) & mask) {
    if (table[slot] == kFree) {
      kept_[count_] = p.array() + 0.0;
      table[slot] = count_++;
      if (2 * std::size_t{count_} > table_.size()) grow();
      return count_ - 1;
    }
    if (kept_[table[slot]] == p) return table[slot];
  }
}

// A file's positions lie anywhere in the table. What all of a block need from memory is asked for before it is used.
void Welder::add_block(std::span<const Vec3> positions, std::uint32_t* indices) {
  const std::uint32_t* const table = table_.data();
  const std::size_t mask = table_.size() - 1, count = positions.size();
  const Vec3* const p = positions.data();
  std::array<std::uint64_t, kBlock> hashes;
  for (std::size_t i = 0; i < count; ++i) {
    hashes.data()[i] = hash(p[i]);
    __builtin_prefetch(table + (hashes.data()[i] & mask));
  }
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t first = table[hashes.data()[i] & mask];
    if (first != kFree) __builtin_prefetch(kept_ + first);
  }
  for (std::size_t i = 0; i < count; ++i) indices[i] = index_of(p[i], hashes.data()[i]);
}

void Welder::add(std::span<const Vec3> positions, std::uint32_t* indices) {
  for (std::size_t first = 0; first < positions.size(); first += kBlock) {
    add_block(positions.subspan(first, std::min(kBlock, positions.size() - first)), indices + first);
  }
}

std::size_t weld(Mesh& mesh) {
  const std::size_t before = mesh.positions.size();
  std::vector<std::uint32_t> welded(before);
  Welder welder(mesh.positions.data(), before / 4);
  welder.add(mesh.positions, welded.data());
  mesh.positions.resize(welder.count());
  for (Triangle& triangle : mesh.triangles) {
    for (std::uint32_t& index : triangle) index = welded.data()[index];
  }
  return before - mesh.positions.size();
}

}  // namespace meshgauge::api
