#include "engine/fast/bounds/owner_cut.h"

#include <cmath>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr int kMaxSteps = 12;  // of a search for a point of equal distances, which mostly needs two to five

}  // namespace

OwnerCut::OwnerCut(const Piece& piece, const Bvh& target, Work& work) : piece_(piece), target_(target), work_(work) {
  for (const Corner& corner : piece.corners) add(corner.slot);
}

bool OwnerCut::add(std::uint32_t slot) {
  const auto end = owners_.begin() + static_cast<std::ptrdiff_t>(count_);
  if (count_ == kMaxOwners || std::find(owners_.begin(), end, slot) != end) return false;
  owners_[count_++] = slot;
  return true;
}

OwnerCut::Attempt OwnerCut::attempt(double limit, int parts) {
  limit_ = limit - rounding::kCutSlack;
  parts_ = parts;
  upper_ = 0;
  too_far_.reset();
  const auto& [a, b, c] = piece_.corners;
  if (bound({measured(a.point), measured(b.point), measured(c.point)}, kMaxDepth) != Verdict::bounded) {
    return {std::nullopt, too_far_};
  }
  return {upper_ + rounding::kCutSlack, std::nullopt};
}

double OwnerCut::from_owner(std::size_t i, const Vec3& x) const {
  ++work_.triangle_tests;
  return distance(target_.prepared(owners_[i]), x);
}

OwnerCut::Point OwnerCut::measured(const Vec3& x) const {
  Point point{x, {}};
  for (std::size_t i = 0; i < count_; ++i) point.distances[i] = from_owner(i, x);
  return point;
}

// Whether x is farther than the limit from all owners; then it is the point that refutes the attempt.
bool OwnerCut::beyond_all(const Vec3& x) {
  for (std::size_t i = 0; i < count_; ++i) {
    if (from_owner(i, x) <= limit_) return false;
  }
  too_far_ = x;
  return true;
}

OwnerCut::Verdict OwnerCut::bound(const Part& part, int depth) {
  if (parts_-- == 0) return Verdict::open;
  for (const Point& point : part) {
    const auto begin = point.distances.begin();
    if (*std::min_element(begin, begin + static_cast<std::ptrdiff_t>(count_)) > limit_) {
      too_far_ = point.at;
      return Verdict::too_far;
    }
  }
  if (bounded_by_one(part)) return Verdict::bounded;
  for (std::size_t i = 0; i < count_; ++i) {
    for (std::size_t j = i + 1; j < count_; ++j) {
      const Verdict verdict = bound_by_pair(part, i, j);
      if (verdict != Verdict::open) return verdict;
    }
  }
  return depth == 0 || parts_ < 2 ? Verdict::open : bisect(part, depth);
}

// Eq. 9.
bool OwnerCut::bounded_by_one(const Part& part) {
  for (std::size_t i = 0; i < count_; ++i) {
    const double most = std::max({part[0].distances[i], part[1].distances[i], part[2].distances[i]});
    if (most > limit_) continue;
    upper_ = std::max(upper_, most);
    return true;
  }
  return false;
}

// One cut between the corners nearer to owner i and those nearer to owner j.
OwnerCut::Verdict OwnerCut::bound_by_pair(const Part& part, std::size_t i, std::size_t j) {
  std::array<bool, 3> at_i;
  double upper = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& distances = part[k].distances;
    at_i[k] = distances[i] <= distances[j];
    upper = std::max(upper, at_i[k] ? distances[i] : distances[j]);
  }
  if (upper > limit_ || (at_i[0] == at_i[1] && at_i[1] == at_i[2])) return Verdict::open;
  const std::size_t alone = at_i[1] == at_i[2] ? 0 : at_i[0] == at_i[2] ? 1 : 2;
  const std::size_t own = at_i[alone] ? i : j, other = at_i[alone] ? j : i;
  for (const std::size_t k : {(alone + 1) % 3, (alone + 2) % 3}) {
    const Verdict verdict = cross(part[alone], part[k], own, other, upper);
    if (verdict != Verdict::bounded) return verdict;
  }
  upper_ = std::max(upper_, upper);
  return Verdict::bounded;
}

OwnerCut::Verdict OwnerCut::bisect(const Part& part, int depth) {
  std::size_t longest = 0;
  double length_sq = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double here = squared_norm(part[k].at - part[(k + 1) % 3].at);
    if (here > length_sq) longest = k, length_sq = here;
  }
  const Point &a = part[longest], &b = part[(longest + 1) % 3], &c = part[(longest + 2) % 3];
  const Point middle = measured((a.at + b.at) * 0.5);
  const Verdict verdict = bound({a, middle, c}, depth - 1);
  return verdict == Verdict::bounded ? bound({middle, b, c}, depth - 1) : verdict;
}

// Looks for a point between a, which is nearer to owner i, and b, nearer to j, that is within the limit of both: by
// regula falsi on the difference of the distances, halving an end that is kept twice. Raises `upper` to the larger
// distance.
OwnerCut::Verdict OwnerCut::cross(const Point& a, const Point& b, std::size_t i, std::size_t j, double& upper) {
  for (const Point* end : {&a, &b}) {
    const double most = std::max(end->distances[i], end->distances[j]);
    if (most <= limit_) return upper = std::max(upper, most), Verdict::bounded;
  }
  double low = 0, high = 1, at_low = a.distances[i] - a.distances[j], at_high = b.distances[i] - b.distances[j];
  int kept = 0;  // -1: the low end was kept last; 1: the high end
  bool beyond = false;
  for (int step = 0; step < kMaxSteps && at_low < 0 && at_high > 0; ++step) {
    const double t = std::clamp(low + (high - low) * (at_low / (at_low - at_high)), low, high);
    const Vec3 x = a.at + t * (b.at - a.at);
    const double to_i = from_owner(i, x), to_j = from_owner(j, x), most = std::max(to_i, to_j);
    if (most <= limit_) return upper = std::max(upper, most), Verdict::bounded;
    const double difference = to_i - to_j;
    if (std::min(to_i, to_j) > limit_) {
      if (!beyond && !beyond_all(x)) return Verdict::open;  // a third one is nearer: not to be had with these two
      beyond = true;
      if (std::abs(difference) <= 0.25 * (most - limit_)) return beyond_all(x) ? Verdict::too_far : Verdict::open;
    }
    if (difference < 0) {
      low = t, at_low = difference;
      if (kept > 0) at_high *= 0.5;
      kept = 1;
    } else {
      high = t, at_high = difference;
      if (kept < 0) at_low *= 0.5;
      kept = -1;
    }
  }
  return beyond ? Verdict::too_far : Verdict::open;
}

}  // namespace meshgauge
