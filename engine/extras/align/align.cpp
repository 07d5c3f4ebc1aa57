#include "engine/extras/align/align.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "engine/extras/align/arithmetic.h"
#include "engine/extras/statistics/surface_sampler.h"
#include "engine/kernels/kernels.h"
#include "engine/thread_pool.h"
#include "engine/tree/nearest.h"

namespace meshgauge {
namespace {

constexpr std::size_t kSamples = 8192;
constexpr std::size_t kStride = 16;  // of the samples, those of a coarse search
constexpr std::size_t kSamplesATask = 64;
constexpr std::uint64_t kSeed = 25;
constexpr int kCoarseSteps = 40;
constexpr int kSteps = 200;
constexpr std::size_t kRefined = 3;     // of the starts, the best after the coarse search
constexpr double kOnSurface = 0x1p-40;  // a sample as near as this lies on the triangle; frame units
constexpr double kNoGain = 0x1p-44;     // of a step, in frame units: converged
constexpr double kSmallGain = 1e-6;     // the same, as a share of the residual
// A fit also ends where a step and the kSlideSteps gaining ones before it gain less than this of the residual together.
constexpr double kSlide = 1e-4, kCoarseSlide = 1e-3;  // with all samples; with few
constexpr int kSlideSteps = 8;
constexpr int kRounds = 4;
constexpr double kMuchLess = 0.995;   // of a residual
constexpr double kTurnAround = 0.35;  // radians
constexpr double kShiftAlong = 0.5;   // of how far the samples spread
constexpr double kLeastDamping = 0x1p-24, kFirstDamping = 0x1p-3, kMostDamping = 0x1p10, kDampingFactor = 8;

Interrupted asking(Control& control) {
  return [&control] { return control.check() != Interruption::none; };
}

// Points of `mesh`, in its unit. Empty: interrupted.
std::vector<Vec3> samples_of(const Prepared& mesh, const Kernels& kernels, Control& control, ThreadPool& pool) {
  const Frame frame(mesh.box());
  const auto framed = mesh.in(frame, kernels);
  const OrderedMesh* ordered = framed->order(control, pool);
  if (!ordered) return {};
  const SurfaceSampler sampler(ordered->view(), kSamples, control);
  if (control.check() != Interruption::none) return {};
  std::mt19937_64 random(kSeed);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < kSamples; ++i) points.push_back(frame.from_frame(sampler.point(i, random)));
  return points;
}

Vec3 mean_of(const std::vector<Vec3>& points) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& p : points) sum += p / static_cast<double>(points.size());
  return sum;
}

struct Principal {
  RigidMotion::Matrix axes;  // a right-handed basis, by column
  Vec3 spread;               // standard deviation along each
};

Principal principal_of(const std::vector<Vec3>& points, const Vec3& mean) {
  RigidMotion::Matrix moments = RigidMotion::Matrix::Zero();
  for (const Vec3& p : points) moments += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  const Eigen::SelfAdjointEigenSolver<RigidMotion::Matrix> solver(moments);
  Principal found{solver.eigenvectors(), solver.eigenvalues().cwiseMax(0).cwiseSqrt()};
  if (found.axes.determinant() < 0) found.axes.col(0) = -found.axes.col(0);
  return found;
}

// The 24 rotations of a cube.
std::vector<RigidMotion::Matrix> cube_rotations() {
  std::vector<RigidMotion::Matrix> all;
  std::array<int, 3> order{0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      RigidMotion::Matrix m = RigidMotion::Matrix::Zero();
      for (int k = 0; k < 3; ++k) m(order[static_cast<std::size_t>(k)], k) = (signs >> k & 1) != 0 ? -1 : 1;
      if (m.determinant() > 0) all.push_back(m);
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

// Sample p goes to turn * (p - centre) + centre + shift; `centre` is that of the samples.
struct Pose {
  Turn turn = Turn::Identity();
  Vec3 shift = Vec3::Zero();
};

struct Sample {
  Vec3 arm;        // from the centre of the pose to the sample
  Vec3 direction;  // of length 1; zero: none
  double distance;
  std::uint32_t slot = Nearest::kNone;  // the nearest triangle
};

struct Fitted {
  Pose pose;
  double residual = std::numeric_limits<double>::infinity();  // frame units
  bool converged = false;
  bool slides = false;  // converged, since several steps together gained little
  int steps = 0;
};

// Direction of a sample at `offset` from its closest point: away from that point, or along the normal of its triangle
// where the sample lies on it.
Vec3 direction_of(const Vec3& offset, const Nearest& found, const Bvh& tree) {
  if (found.distance > kOnSurface) return offset / found.distance;
  const PreparedTriangle triangle = tree.prepared(found.slot);
  const Vec3 normal = triangle.e1.cross(triangle.e2);
  return dot(normal, offset) < 0 ? Vec3(-normal) : normal;
}

// Fits samples to a tree, in its frame.
class Fitting {
 public:
  Fitting(std::vector<Vec3> samples, const Bvh& tree, double overlap, Control& control, ThreadPool& pool)
      : samples_(std::move(samples)),
        centre_(mean_of(samples_)),
        tree_(tree),
        overlap_(overlap),
        control_(control),
        pool_(pool) {}

  const Vec3& centre() const { return centre_; }

  // nullopt: interrupted. `stride`: of the samples, those that are used.
  std::optional<Fitted> fit(const Pose& start, std::size_t stride, int most_steps);

 private:
  double residual(const Pose& pose, std::size_t stride);
  Pose step(const Pose& from, double damping) const;

  const std::vector<Vec3> samples_;
  const Vec3 centre_;
  const Bvh& tree_;
  const double overlap_;
  Control& control_;
  ThreadPool& pool_;
  std::atomic<bool> stopped_{false};
  std::vector<Sample> seen_, tried_;
  double farthest_seen_ = 0, farthest_ = 0;  // of the samples of each that count
};

// Infinite: interrupted, or the pose is not finite.
double Fitting::residual(const Pose& pose, std::size_t stride) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  if (!pose.shift.allFinite() || !pose.turn.coeffs().allFinite()) return kNone;
  tried_.resize(samples_.size() / stride);
  const Interrupted stop = asking(control_);
  pool_.run((tried_.size() + kSamplesATask - 1) / kSamplesATask, [&](std::size_t, std::size_t task) {
    std::uint64_t tests = 0;
    const std::size_t end = std::min((task + 1) * kSamplesATask, tried_.size());
    for (std::size_t i = task * kSamplesATask; i < end && !stopped_; ++i) {
      Sample& sample = tried_[i];
      sample.arm = pose.turn * (samples_[i * stride] - centre_);
      const Vec3 at = centre_ + pose.shift + sample.arm;
      const Nearest found = nearest(tree_, at, tests, sample.slot, &stop);
      if (!found.complete || stop()) stopped_ = true;
      sample.distance = found.distance;
      sample.slot = found.slot;
      sample.direction = direction_of(at - found.point, found, tree_);
    }
  });
  if (stopped_) return kNone;
  std::vector<double> distances;
  for (const Sample& sample : tried_) distances.push_back(sample.distance);
  const auto kept =
      std::max<std::size_t>(1, static_cast<std::size_t>(overlap_ * static_cast<double>(distances.size())));
  std::nth_element(distances.begin(), distances.begin() + static_cast<std::ptrdiff_t>(kept - 1), distances.end());
  farthest_ = distances[kept - 1];
  // In the order of the samples: nth_element() leaves open in which order those below the farthest are.
  double sum = 0;
  std::size_t nearer = 0;
  for (const Sample& sample : tried_) {
    if (sample.distance < farthest_) sum += sample.distance * sample.distance, ++nearer;
  }
  sum += static_cast<double>(kept - nearer) * (farthest_ * farthest_);
  return std::sqrt(sum / static_cast<double>(kept));
}

Pose Fitting::step(const Pose& from, double damping) const {
  Mat6 a = Mat6::Identity() * std::numeric_limits<double>::min();
  Vec6 b = Vec6::Zero();
  for (const Sample& sample : seen_) {
    if (sample.distance > farthest_seen_) continue;
    Vec6 row;
    row << sample.arm.cross(sample.direction), sample.direction;
    a += row * row.transpose();
    b -= row * sample.distance;
    Eigen::Matrix<double, 3, 6> velocity;                     // of the sample, from turn and shift
    velocity << 0, sample.arm.z(), -sample.arm.y(), 1, 0, 0,  //
        -sample.arm.z(), 0, sample.arm.x(), 0, 1, 0,          //
        sample.arm.y(), -sample.arm.x(), 0, 0, 0, 1;
    for (int k = 0; k < 3; ++k) a += damping * velocity.row(k).transpose() * velocity.row(k);
  }
  const Vec6 x = solve(a, b);
  return {composed(turn_by(x.head<3>()), from.turn), from.shift + x.tail<3>()};
}

// The surface may slide along the other one, as a sphere does: there each step gains a little, for long.
std::optional<Fitted> Fitting::fit(const Pose& start, std::size_t stride, int most_steps) {
  Fitted best{start, residual(start, stride)};
  double damping = kFirstDamping;
  std::array<double, kSlideSteps> before;  // the residuals before the last steps that gained
  int gains = 0;
  const double slide = stride > 1 ? kCoarseSlide : kSlide;
  before.fill(std::numeric_limits<double>::infinity());
  const auto accept = [this] { seen_ = tried_, farthest_seen_ = farthest_; };
  for (accept(); !stopped_ && !best.converged && best.steps < most_steps; ++best.steps) {
    const Pose next = step(best.pose, damping);
    const double found = residual(next, stride);
    if (found < best.residual) {
      double& long_ago = before[static_cast<std::size_t>(gains++ % kSlideSteps)];
      const double gain = best.residual - found;
      best.slides = long_ago - found < slide * found;
      best.converged = gain < kNoGain || (gain < kSmallGain * best.residual && damping < kFirstDamping) || best.slides;
      long_ago = best.residual;
      best.pose = next;
      best.residual = found;
      damping = std::max(damping / kDampingFactor, kLeastDamping);
      accept();
    } else {
      damping *= kDampingFactor;
      best.converged = damping > kMostDamping;
    }
  }
  return stopped_ ? std::nullopt : std::optional(best);
}

// `pose` and others, turned from it about the principal axes and shifted along them by shares of how far the samples
// spread, so that a near minimum does not catch the search. `reach`: 1, or less for nearer ones.
std::vector<Pose> poses_around(const Pose& pose, const Principal& principal, double reach) {
  std::vector<Pose> poses{pose};
  for (int k = 0; k < 3; ++k) {
    const Vec3 axis = principal.axes.col(k);
    for (const double part : {-2 * reach, -reach, reach, 2 * reach})
      poses.push_back({composed(pose.turn, turn_by(part * kTurnAround * axis)), pose.shift});
    for (const double part : {-reach, reach})
      poses.push_back({pose.turn, pose.shift + part * kShiftAlong * principal.spread[k] * (pose.turn * axis)});
  }
  return poses;
}

// The poses that lay the principal axes of the samples on those of `fixed`.
std::vector<Pose> poses_of_axes(const std::vector<Vec3>& samples, const std::vector<Vec3>& fixed) {
  const Vec3 from = mean_of(samples), to = mean_of(fixed);
  const RigidMotion::Matrix axes_from = principal_of(samples, from).axes, axes_to = principal_of(fixed, to).axes;
  std::vector<Pose> poses;
  for (const RigidMotion::Matrix& turn : cube_rotations()) {
    poses.push_back({Turn(product(product(axes_to, turn), axes_from.transpose())), to - from});
  }
  return poses;
}

// Searches from every start with few samples, then from the first and the best with all, unless the few samples have
// shown that it is hardly better. What is hardly better than the pose of an earlier one is left: of many like poses, as
// those of a gear, that of the first start is the answer.
std::optional<Fitted> best_of(Fitting& fitting, const std::vector<Pose>& starts) {
  std::vector<Fitted> coarse;
  for (const Pose& start : starts) {
    const auto found = fitting.fit(start, kStride, kCoarseSteps);
    if (!found) return std::nullopt;
    coarse.push_back(*found);
  }
  std::ranges::stable_sort(coarse.begin() + 1, coarse.end(), {}, &Fitted::residual);
  coarse.resize(std::min(coarse.size(), 1 + kRefined));
  std::optional<Fitted> best;
  double of_few = 0;  // the residual of the best one with few samples
  for (const Fitted& one : coarse) {
    if (best && one.converged && !one.slides && !(one.residual < kMuchLess * of_few)) continue;
    auto found = fitting.fit(one.pose, 1, kSteps);
    if (!found) return std::nullopt;
    found->steps += one.steps;
    if (!best || found->residual < kMuchLess * best->residual) best = found, of_few = one.residual;
  }
  return best;
}

// Searches from every start, then again around what it found, ever nearer, as long as that helps: of a gear's teeth,
// the next one is often nearer than a turn of the first round.
std::optional<Fitted> search(Fitting& fitting, std::vector<Pose> starts, const Principal& principal) {
  std::optional<Fitted> best;
  for (int round = 0; round < kRounds; ++round) {
    const auto found = best_of(fitting, starts);
    if (!found) return std::nullopt;
    const bool helps = !best || found->residual < kMuchLess * best->residual;
    if (helps) best = found;
    if (!helps || best->residual < kOnSurface) break;
    starts = poses_around(best->pose, principal, 1.0 / (round + 2));
  }
  return best;
}

// The same motion in the meshes' unit, after `start`.
RigidMotion motion_of(const Pose& pose, const Vec3& centre, const Frame& frame, const RigidMotion& start) {
  const RigidMotion::Matrix turn = pose.turn.toRotationMatrix();
  const Vec3 about = frame.from_frame(centre), to = frame.from_frame(centre + pose.shift);
  return {nearest_rotation(product(turn, start.rotation)), product(turn, start.translation - about) + to};
}

std::optional<Alignment> align_samples(const Prepared& moving, const Prepared& fixed, const AlignOptions& options,
                                       const Kernels& kernels, Control& control, ThreadPool& pool) {
  std::vector<Vec3> samples = samples_of(moving, kernels, control, pool);
  if (samples.empty()) return std::nullopt;
  Box box = fixed.box();
  for (Vec3& p : samples) box.extend(p = options.start(p));
  const Frame frame(box);
  const auto framed = fixed.in(frame, kernels);
  const Bvh* tree = framed->tree(control, pool);
  if (!tree) return std::nullopt;
  for (Vec3& p : samples) p = frame.to_frame(p);

  const Principal principal = principal_of(samples, mean_of(samples));
  std::vector<Pose> starts = poses_around({}, principal, 1);
  if (options.principal_axes) {
    std::vector<Vec3> others = samples_of(fixed, kernels, control, pool);
    if (others.empty()) return std::nullopt;
    for (Vec3& p : others) p = frame.to_frame(p);
    for (const Pose& pose : poses_of_axes(samples, others)) starts.push_back(pose);
  }
  Fitting fitting(std::move(samples), *tree, options.overlap, control, pool);
  const auto given = fitting.fit({}, 1, 0);
  if (!given) return std::nullopt;
  const auto length = [&](double x) { return std::ldexp(x, frame.exponent()); };
  Alignment result{options.start, length(given->residual), length(given->residual)};
  result.samples = kSamples;
  if (!options.fit) return result;
  const auto best = search(fitting, starts, principal);
  if (!best) return std::nullopt;
  result.starts = static_cast<int>(starts.size());
  result.converged = best->converged;
  result.steps = best->steps;
  if (!(best->residual + kNoGain < given->residual)) return result;  // what lies in place is not moved
  result.motion = motion_of(best->pose, fitting.centre(), frame, options.start);
  result.residual = length(best->residual);
  return result;
}

}  // namespace

std::optional<Alignment> align(const Prepared& moving, const Prepared& fixed, const AlignOptions& options,
                               unsigned threads, std::string_view simd, Control& control) {
  const Kernels& kernels = *find_kernels(simd);
  ThreadPool pool(std::max(threads, 1U));
  if (!is_cloud(fixed.mesh()) || is_cloud(moving.mesh()))
    return align_samples(moving, fixed, options, kernels, control, pool);
  AlignOptions inverse = options;
  inverse.start = options.start.inverse();
  auto found = align_samples(fixed, moving, inverse, kernels, control, pool);
  if (found) found->motion = options.fit ? found->motion.inverse() : options.start;
  return found;
}

}  // namespace meshgauge
