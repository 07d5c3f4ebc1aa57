#include "engine/extras/display/deviation.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>

#include "engine/extras/area/area_stage.h"
#include "engine/extras/area/winding.h"
#include "engine/fast/twins.h"
#include "engine/mesh/frame.h"
#include "engine/mesh/topology.h"
#include "engine/rounding.h"
#include "engine/search/measured_pair.h"
#include "engine/thread_pool.h"
#include "engine/tree/nearest.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlockSize = 256;  // vertices; consecutive ones are neighbours in space

class Measuring {
 public:
  Measuring(const Prepared& from, const Prepared& to, const DeviationOptions& options, Control& control)
      : from_(from),
        to_(to),
        kernels_(*find_kernels(options.simd)),
        upper_(options.upper),
        wants_sides_(options.sides),
        control_(control),
        pool_(std::max(options.threads, 1U)),
        frame_(joint(from.box(), to.box())),
        slack_(rounding::kMinorantSlack + frame_.length_to_frame_up(InputError(from, to).value())) {}

  std::optional<Deviation> run() {
    const std::size_t vertices = from_.mesh().positions.size();
    result_.distances.assign(vertices, 0);
    result_.nearest.assign(vertices, Deviation::kNone);
    if (wants_sides_ && !look_for_sides()) return std::nullopt;
    settle_shared();
    if (stopped() || !(await_vertices() && measure_waiting())) return std::nullopt;
    const auto farthest = std::max_element(result_.distances.begin(), result_.distances.end());
    result_.farthest = static_cast<std::uint32_t>(farthest - result_.distances.begin());
    return std::move(result_);
  }

 private:
  // A vertex to measure.
  struct Waiting {
    std::uint32_t vertex;   // number in the given mesh
    std::uint32_t ordered;  // number in the ordered mesh
  };

  static Box joint(Box box, const Box& other) {
    box.extend(other);
    return box;
  }

  bool stopped() { return control_.check() != Interruption::none; }

  // False: interrupted.
  bool look_for_sides() {
    const auto known = topology(to_.mesh(), to_.box(), [this] { return stopped(); });
    if (known && !refusal_of(*known)) result_.sides.assign(result_.distances.size(), 0);
    return known.has_value();
  }

  void settle_shared() {
    const auto twins = shared_triangles(from_.mesh(), to_, [this] { return stopped(); });
    for (std::size_t t = 0; t < twins.size(); ++t) {
      if (twins[t] == kNoTwin) continue;
      for (const std::uint32_t v : from_.mesh().triangles[t]) result_.nearest[v] = twins[t];
    }
  }

  // Collects the vertices to measure in the order of the mesh, so that the nearest triangle of one is a hint for the
  // next. False: interrupted.
  bool await_vertices() {
    framed_from_ = from_.in(frame_, kernels_);
    ordered_ = framed_from_->order(control_, pool_);
    if (!ordered_) return false;
    std::vector<bool> seen(ordered_->positions.size());
    for (std::uint32_t t = 0; t < ordered_->triangles.size(); ++t) {
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t ordered = ordered_->triangles[t][i];
        const std::uint32_t vertex = from_.mesh().triangles[ordered_->original[t]][i];
        if (seen[ordered] || result_.nearest[vertex] != Deviation::kNone) continue;
        seen[ordered] = true;
        waiting_.push_back({vertex, ordered});
      }
    }
    return true;
  }

  bool measure_waiting() {
    if (waiting_.empty()) return true;
    framed_to_ = to_.in(frame_, kernels_);
    tree_ = framed_to_->tree(control_, pool_);
    if (!tree_) return false;
    target_ = framed_to_->order(control_, pool_);
    std::atomic<bool> stop{!target_};
    pool_.run((waiting_.size() + kBlockSize - 1) / kBlockSize, [&](std::size_t, std::size_t block) {
      if (stop.load(std::memory_order_relaxed) || stopped() || !measure_block(block)) stop = true;
    });
    return !stop;
  }

  bool measure_block(std::size_t block) {
    std::uint64_t tests = 0;
    Work work;
    const Interrupted stop = [this] { return stopped(); };
    Polling polling(&stop, tests);
    std::uint32_t hint = Nearest::kNone;
    const std::size_t end = std::min(waiting_.size(), (block + 1) * kBlockSize);
    for (std::size_t i = block * kBlockSize; i < end; ++i) {
      const Vec3& p = ordered_->positions[waiting_[i].ordered];
      const Nearest found = nearest(*tree_, p, tests, hint, &stop);
      if (!found.complete || polling.poll(tests)) return false;
      hint = found.slot;
      const std::uint32_t vertex = waiting_[i].vertex;
      result_.nearest[vertex] = target_->original[found.slot];
      result_.distances[vertex] = is_corner(p, found.slot) ? 0 : certified(found.distance);
      if (!result_.sides.empty() && result_.distances[vertex] > 0) result_.sides[vertex] = side_of(p, work, stop);
    }
    return result_.sides.empty() || !stopped();  // which ends the search for a side as well
  }

  // As for a single point in docs/design.md, section 13.
  std::int8_t side_of(const Vec3& p, Work& work, const Interrupted& stop) const {
    const auto below = certified_distance_below(*tree_, p, &stop, 2 * slack_);
    if (!below || !(rounding::subtract_down(*below, slack_) > 0)) return 0;
    const auto winding = winding_number(*tree_, p, work, &stop);
    if (!winding || *winding < 0) return 0;
    return *winding > 0 ? -1 : 1;
  }

  double certified(double distance) const { return std::min(std::ldexp(distance, frame_.exponent()), upper_); }

  bool is_corner(const Vec3& p, std::uint32_t slot) const {
    const MeshView view = target_->view();
    return p == view.corner(slot, 0) || p == view.corner(slot, 1) || p == view.corner(slot, 2);
  }

  const Prepared& from_;
  const Prepared& to_;
  const Kernels& kernels_;
  const double upper_;
  const bool wants_sides_;
  Control& control_;
  ThreadPool pool_;
  const Frame frame_;
  const double slack_;  // how far a vertex may be from the exact one, in frame units
  std::shared_ptr<Framed> framed_from_;
  std::shared_ptr<Framed> framed_to_;
  const OrderedMesh* ordered_ = nullptr;  // of `from`
  const OrderedMesh* target_ = nullptr;   // of `to`
  const Bvh* tree_ = nullptr;
  std::vector<Waiting> waiting_;
  Deviation result_;
};

}  // namespace

std::optional<Deviation> deviation(const Prepared& from, const Prepared& to, const DeviationOptions& options,
                                   Control& control) {
  return Measuring(from, to, options, control).run();
}

}  // namespace meshgauge
