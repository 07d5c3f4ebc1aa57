// The state of the sweep (engine/fast/sweep.h): of one thread, and of a vertex of A.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "engine/fast/bounds/overlay.h"
#include "engine/fast/bounds/patch.h"
#include "engine/search/search_worker.h"

namespace meshgauge {

// The distance of a vertex of A from B and a triangle for its queries. Thread safe: two threads may measure a vertex of
// two blocks at the same time, and both results are right.
class Vertex {
 public:
  bool measured() const { return distance_.load(std::memory_order_acquire) >= 0; }
  double distance() const { return distance_.load(std::memory_order_relaxed); }
  // The nearest triangle of B if measured(), else one that culled a neighbour, or kNone.
  std::uint32_t slot() const { return slot_.load(std::memory_order_relaxed); }
  void set(double distance, std::uint32_t slot) {
    slot_.store(slot, std::memory_order_relaxed);
    distance_.store(distance, std::memory_order_release);
  }
  void suggest(std::uint32_t slot) {
    if (!measured()) slot_.store(slot, std::memory_order_relaxed);
  }

 private:
  std::atomic<double> distance_{-1};
  std::atomic<std::uint32_t> slot_{Nearest::kNone};
};

// Whether a corner of the triangle is measured and beyond `limit`.
inline bool is_beyond(std::span<const Vertex> vertices, const Triangle& triangle, double limit) {
  return std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return vertices[v].distance() > limit; });
}

// The recent success rate of a kind of attempt, to decide whether to try it.
class Record {
 public:
  // `rate`: the success rate to begin with. `memory`: about so many attempts count.
  explicit Record(float rate = 0, float memory = 16) : rate_(rate), memory_(memory) {}
  bool note(bool success) {
    rate_ += ((success ? 1.0F : 0.0F) - rate_) / memory_;
    return success;
  }
  // Whether more than half of the recent attempts succeeded. Also true for every 64th call, to notice a change.
  bool promising() { return good() || ++asked_ % 64 == 0; }
  bool good() const { return rate_ > 0.5F; }
  // Whether one of some thirty recent attempts succeeded. Also true for every 32nd call.
  bool possible() { return rate_ > 1.0F / 32 || ++skipped_ % 32 == 0; }

 private:
  float rate_;
  float memory_;
  unsigned asked_ = 0;
  unsigned skipped_ = 0;
};

// Up to four different triangles of B.
class Hints {
 public:
  void add(std::uint32_t slot) {
    const auto end = slots_.begin() + size_;
    if (slot != Nearest::kNone && std::find(slots_.begin(), end, slot) == end)
      slots_[static_cast<std::size_t>(size_++)] = slot;
  }
  std::span<const std::uint32_t> span() const { return {slots_.data(), static_cast<std::size_t>(size_)}; }

 private:
  std::array<std::uint32_t, 4> slots_;
  std::ptrdiff_t size_ = 0;
};

// What attempts have shown.
struct Experience {
  Record guesses;           // attempts with triangles of B that need no query
  Record patches{1, 4};     // attempts with the patch certificate, by block
  Record centroids{0.25F};  // attempts with the triangle nearest to the centroid
  Record overlays;          // attempts with the overlay bound
  Record twins;             // attempts with the triangle of the same number
  Record successors;        // attempts with the triangle after `last`
};

// One thread's state in the sweep. No two share a cache line, which both would write.
struct alignas(64) Sweeper : Experience {
  SearchWorker worker;
  std::optional<Overlay> overlay;
  std::optional<Patch> patch;
  // The triangle of B used last; kNone as long as other threads have measured all vertices that this one needed.
  std::uint32_t last = Nearest::kNone;
  std::size_t guessed = 0;          // triangles of A for which guesses were tried
  std::size_t uncertified = 0;      // of those, the ones that no guess culled
  std::vector<std::uint32_t> left;  // triangles of the block that are not culled yet

  explicit Sweeper(Search& search) : worker(search) {}
};

inline const Sweeper& most_experienced(const std::deque<Sweeper>& sweepers) {
  return *std::max_element(sweepers.begin(), sweepers.end(),
                           [](const Sweeper& x, const Sweeper& y) { return x.guessed < y.guessed; });
}

// Lets all threads go on with this experience: to learn the same takes each of them hundreds of triangles.
inline void share(const Experience& known, std::deque<Sweeper>& sweepers) {
  for (Sweeper& sweeper : sweepers) static_cast<Experience&>(sweeper) = known;
}

}  // namespace meshgauge
