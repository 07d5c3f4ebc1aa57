#include "engine/extras/area/places.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <utility>
#include <vector>

#include "engine/fast/sweep.h"
#include "engine/kernels/kernels.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/search/conclusion.h"
#include "engine/search/search.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlocksATask = 4;
constexpr std::size_t kWorthASweep = 16;  // the sweep looks at all blocks: one triangle of so many has to be unknown

double gap_sq(const Box& a, const Box& b) {
  return squared_norm((a.low - b.high).cwiseMax(b.low - a.high).cwiseMax(0.0));
}

// Whether each triangle of B is surely farther than `limit` from the box: so are their boxes, or those around them
// (R6). False also when `stop`, which is polled about every 0.1 ms, returned true.
bool is_beyond(const Bvh& to, const Box& box, double limit, const Interrupted& stop) {
  constexpr std::size_t kVisitsALook = 1024;
  const double near = far_limit(limit * limit);
  std::array<std::uint32_t, kMaxStack> stack;
  std::size_t size = 0, visits = 0;
  stack[size++] = Bvh::kRoot;
  while (size > 0) {
    if (++visits % kVisitsALook == 0 && stop()) return false;
    const std::uint32_t child = stack[--size];
    if (child & WideNode::kLeaf) {
      const std::uint32_t block = child & ~WideNode::kLeaf;
      for (std::uint32_t t = Bvh::block_begin(block); t < to.block_end(block); ++t) {
        Box around;
        for (int i = 0; i < 3; ++i) around.extend(to.mesh().corner(t, i));
        if (gap_sq(box, around) <= near) return false;
      }
      continue;
    }
    const WideNode& node = to.nodes()[child];
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (node.child[lane] != WideNode::kNone && gap_sq(box, Bvh::child_box(node, lane)) <= near)
        stack[size++] = node.child[lane];
    }
  }
  return true;
}

// Ends a sweep when the job must end.
class AreaMonitor final : public Monitor {
 public:
  explicit AreaMonitor(Control& control) : control_(control) {}
  std::optional<Stop> pulse(const Search&) override {
    const Interruption why = control_.check();
    return why == Interruption::none ? std::nullopt : std::optional(to_stop(why));
  }
  bool interrupted() override { return control_.check() != Interruption::none; }

 private:
  Control& control_;
};

class PlaceFinder {
 public:
  // By R3, R4 and the input error, a computed bound of `low` less the slack shows `within`.
  PlaceFinder(const AreaDirection& in, double low, double high)
      : in_(in),
        slack_(rounding::upper_slack(in.to.residual(), 0) + in.error + 32 * rounding::kUnit),
        given_low_(low),
        low_(low - slack_),
        high_(high + slack_) {
    places_.assign(in.from.triangles.size(), Place::unknown);
  }

  std::optional<LargeArray<Place>> run() {
    if (!place_known() || !place_blocks()) return std::nullopt;
    if (unknown_ * kWorthASweep >= places_.size() && low_ > 0 && !sweep_within()) return std::nullopt;
    return std::move(places_);
  }

 private:
  Box box_of(std::size_t begin, std::size_t end) const {
    Box box;
    for (std::size_t t = begin; t < end; ++t) {
      for (int i = 0; i < 3; ++i) box.extend(in_.from.view().corner(t, i));
    }
    return box;
  }
  void set(std::size_t begin, std::size_t end, Place place) {
    for (std::size_t t = begin; t < end; ++t) places_[t] = place;
  }

  // By the bounds that the search for the largest distance has met.
  bool place_known() {
    if (in_.bounds.empty()) return true;
    const double most = rounding::subtract_down(given_low_, in_.error);
    bounds_.resize(places_.size());
    return each_unless(stop_, places_.size(), [&](std::size_t t) {
      bounds_[t] = in_.bounds[in_.from.original[t]];
      if (static_cast<double>(bounds_[t]) <= most) places_[t] = Place::within;
    });
  }

  // With c the middle of a block's box and r half its diagonal: d(x,B) <= d(c,B) + r for its points x.
  bool place_blocks() {
    std::atomic<bool> stopped{false};
    std::atomic<std::size_t> unknown{0};
    const std::size_t size = in_.options.thresholds.block;  // consecutive triangles are neighbours in space
    const std::size_t count = (places_.size() + size - 1) / size;
    in_.pool.run((count + kBlocksATask - 1) / kBlocksATask, [&](std::size_t, std::size_t task) {
      if (stopped || stop_()) stopped = true;
      std::uint32_t hint = Nearest::kNone;
      Work work;
      for (std::size_t b = task * kBlocksATask; b < std::min(count, (task + 1) * kBlocksATask) && !stopped; ++b) {
        const std::size_t begin = b * size, end = std::min(begin + size, places_.size());
        const auto open =
            static_cast<std::size_t>(std::count(places_.begin() + static_cast<std::ptrdiff_t>(begin),
                                                places_.begin() + static_cast<std::ptrdiff_t>(end), Place::unknown));
        if (open == 0) continue;
        const Box box = box_of(begin, end);
        if (open == end - begin && is_beyond(in_.to, box, high_, stop_)) {
          set(begin, end, Place::beyond);
          continue;
        }
        const Vec3 centre = (box.low + box.high) * 0.5;
        const Corner found = nearest_corner(in_.to, centre, work, &stop_, hint);
        hint = found.slot;
        if (!found.complete) stopped = true;
        if (found.distance + farthest_of_box(box, centre) + rounding::kDistanceSlack <= low_) {
          set(begin, end, Place::within);
          continue;
        }
        unknown += open;
        if (open < end - begin || found.distance <= high_) continue;
        for (std::size_t few = begin; few < end; few += kLanes) {
          const std::size_t last = std::min(few + kLanes, end);
          if (!is_beyond(in_.to, box_of(few, last), high_, stop_)) continue;
          set(few, last, Place::beyond);
          unknown -= last - few;
        }
      }
    });
    unknown_ = unknown;
    return !stopped;
  }

  // What the sweep drops has a computed bound of at most `cull_at`. False: interrupted; without the memory for it,
  // nothing changes.
  bool sweep_within() {
    AreaMonitor monitor(in_.control);
    bounds_.resize(places_.size(), std::numeric_limits<float>::infinity());
    for (std::size_t t = 0; t < places_.size(); ++t) {
      if (places_[t] != Place::unknown) bounds_[t] = 0;  // it needs no visit
    }
    Goal goal;
    goal.cull_at = low_;
    Search search(in_.from.view(), in_.from.box, in_.to, goal, 0, monitor, in_.pool);
    search.set_options(in_.options);
    search.set_known(bounds_);
    search.set_adjacency_source([this] { return &in_.adjacency; });
    search.take_adjacency();
    if (const auto why = sweep(search, in_.from, in_.to_mesh)) return *why == Stop::budget;
    search.depth_first();
    std::vector<bool> kept(places_.size());
    const std::size_t count = search.waiting();
    return each_unless(stop_, count, [&](std::size_t) { kept[search.pop().triangle] = true; }) &&
           each_unless(stop_, places_.size(), [&](std::size_t t) {
             if (places_[t] == Place::unknown && !kept[t]) places_[t] = Place::within;
           });
  }

  const AreaDirection& in_;
  const Interrupted stop_ = [this] { return in_.control.check() != Interruption::none; };
  const double slack_;
  const double given_low_, low_, high_;
  LargeArray<float> bounds_;  // by triangle of A; empty: none are known
  LargeArray<Place> places_;
  std::size_t unknown_ = 0;
};

}  // namespace

std::optional<LargeArray<Place>> places_of(const AreaDirection& direction, double low, double high) {
  return PlaceFinder(direction, low, high).run();
}

}  // namespace meshgauge
