#include "engine/fast/bounds/patch.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include "engine/rounding.h"

namespace meshgauge {
namespace {

constexpr double kOffset = rounding::kPatchOffset;

constexpr std::size_t kMaxLeavesATriangle = 6;  // limit of the leaves of B under a group, for each triangle of it
constexpr double kSimilar = 0.7;  // least cosine between the normals of a group and that of its first triangle
constexpr std::size_t kTestsOfLeaf = 4 * kLanes;  // point-triangle distances that cost as much as projecting a leaf
constexpr std::array kInnerWeights{0.375, 0.34375, 0.28125};  // uneven: B's edges rarely run through the point

// An orthonormal frame whose third axis is `direction`, a unit vector. `mirrored`: seen from behind.
PatchFrame frame_along(const Vec3& direction, const Vec3& origin, bool mirrored) {
  int least = 0;
  direction.cwiseAbs().minCoeff(&least);
  const Vec3 first = normalized(Vec3::Unit(least).cross(direction));
  const Vec3 second = mirrored ? Vec3(first.cross(direction)) : Vec3(direction.cross(first));
  PatchFrame frame;
  for (int k = 0; k < 3; ++k) {
    frame.origin[k] = origin[k];
    frame.axes[0][k] = first[k];
    frame.axes[1][k] = second[k];
    frame.axes[2][k] = direction[k];
  }
  return frame;
}

void put(const Vec3& p, PointBlock& block, std::size_t lane) {
  for (int k = 0; k < 3; ++k) block.at[k][lane] = p[k];
}

// The largest of sign * value over the lanes.
template <int sign>
double largest(const double (&values)[kLanes]) {
  std::array<double, kLanes> rest;
  for (std::size_t i = 0; i < kLanes; ++i) rest[i] = sign * values[i];
  for (std::size_t half = kLanes / 2; half > 0; half /= 2) {
    for (std::size_t i = 0; i < half; ++i) rest[i] = std::max(rest[i], rest[i + half]);
  }
  return rest[0];
}

// 1 if two boxes meet, else 0. Without branches: they would be mispredicted.
std::size_t meet(const auto& a, const auto& b) {
  return static_cast<std::size_t>((a.low_x <= b.high_x) & (a.high_x >= b.low_x) & (a.low_y <= b.high_y) &
                                  (a.high_y >= b.low_y));
}

Vec2 corner(const PatchBlock& block, std::size_t lane, std::size_t i) {
  return {block.x[i % 3][lane], block.y[i % 3][lane]};
}

HalfPlane inner_side(const PatchBlock& block, std::size_t lane, std::size_t edge) {
  return left_of(corner(block, lane, edge), corner(block, lane, edge + 1));
}

}  // namespace

// A triangle of A in the patch frame.
struct Patch::View {
  const PatchPiece& piece;
  Polygon polygon;
  std::array<HalfPlane, 3> sides;

  explicit View(const PatchPiece& p) : piece(p) {
    for (std::size_t i = 0; i < 3; ++i) polygon.add({p.x[i], p.y[i]});
    for (std::size_t i = 0; i < 3; ++i) sides[i] = left_of(polygon.corners[i], polygon.corners[(i + 1) % 3]);
  }

  // Whether the edge of that lane meets the piece. Errs to yes.
  bool meets(const PatchBlock& block, std::size_t lane, std::size_t edge) const {
    const Vec2 a = corner(block, lane, edge), b = corner(block, lane, edge + 1);
    for (const HalfPlane& side : sides) {
      if (side.surely_outside(a, kOffset) && side.surely_outside(b, kOffset)) return false;
    }
    const HalfPlane line = left_of(a, b);
    const auto all = [&](auto&& test) { return test(0) && test(1) && test(2); };
    return !all([&](std::size_t i) { return line.surely_inside(polygon.corners[i], kOffset); }) &&
           !all([&](std::size_t i) { return line.surely_outside(polygon.corners[i], kOffset); });
  }

  // The range of the difference of height over the common part with the image of that lane, errors included. An empty
  // range: they do not meet.
  std::pair<double, double> gap(const PatchBlock& block, std::size_t lane) const {
    Polygon common = polygon;
    for (std::size_t e = 0; e < 3; ++e) clip(common, inner_side(block, lane, e), kOffset);
    const double slope_x = piece.slope_x - block.slope_x[lane], slope_y = piece.slope_y - block.slope_y[lane];
    const double level = piece.level - block.level[lane], error = piece.error + block.error[lane];
    std::pair range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < common.size; ++i) {
      const double height = level + slope_x * common.corners[i].x() + slope_y * common.corners[i].y();
      range.first = std::min(range.first, height - error);
      range.second = std::max(range.second, height + error);
    }
    return range;
  }
};

Patch::Patch(const Bvh& target, const Adjacency& adjacency, std::size_t min_group)
    : target_(target),
      adjacency_(adjacency),
      min_group_(min_group),
      gathered_((target.mesh().triangles.size() + kLanes - 1) / kLanes) {}

std::span<const Patch::Bound> Patch::attempt(MeshView from, std::span<const std::uint32_t> triangles, double limit,
                                             Work& work) {
  bounds_.assign(triangles.size(), {});
  const double rest = limit - rounding::kPatchSlack;
  if (!(rest > 0)) return bounds_;
  take_normals(from, triangles);
  while (next_group(from, triangles)) {
    if (gather(rest, work)) bound_group(from, triangles, rest, work);
  }
  return bounds_;
}

void Patch::take_normals(MeshView from, std::span<const std::uint32_t> triangles) {
  normals_.clear();
  for (const std::uint32_t t : triangles) {
    const Vec3& a = from.corner(t, 0);
    const Vec3 normal = (from.corner(t, 1) - a).cross(from.corner(t, 2) - a);
    const double length = norm(normal);
    normals_.push_back(length > rounding::kPatchSmallest ? Vec3(normal / length) : Vec3(Vec3::Zero()));
  }
}

// Makes the next group of triangles with similar normals. False: there is none of enough triangles.
bool Patch::next_group(MeshView from, std::span<const std::uint32_t> triangles) {
  for (std::size_t first = 0; first < normals_.size(); ++first) {
    if (normals_[first].isZero()) continue;
    const Vec3 like = normals_[first];
    group_.members.clear();
    Vec3 sum = Vec3::Zero();
    for (std::size_t i = first; i < normals_.size(); ++i) {
      if (!(dot(normals_[i], like) > kSimilar)) continue;
      group_.members.push_back(i);
      sum += normals_[i];
      normals_[i].setZero();
    }
    if (group_.members.size() < min_group_) continue;
    group_.direction = normalized(sum);
    group_.box = Box();
    for (const std::size_t i : group_.members) {
      for (int k = 0; k < 3; ++k) group_.box.extend(from.corner(triangles[i], k));
    }
    return true;
  }
  return false;
}

// Projects B's triangles within `limit` of the group along its direction. False: there are too many or none.
bool Patch::gather(double limit, Work& work) {
  const Vec3 reach = limit * group_.direction.cwiseAbs();
  leaves_within({group_.box.low - reach, group_.box.high + reach});
  if (leaves_.empty() || leaves_.size() > kMaxGrounds || leaves_.size() > kMaxLeavesATriangle * group_.members.size())
    return false;
  if (grounds_.size() < leaves_.size()) grounds_.resize(leaves_.size());
  ground_size_ = leaves_.size();
  work.triangle_tests += ground_size_ * kTestsOfLeaf;
  const Vec3 origin = (group_.box.low + group_.box.high) * 0.5;
  frame_ = frame_along(group_.direction, origin, mirrored_);
  const Orientations seen = project_leaves(frame_);
  if (seen.right > seen.left) {
    mirrored_ = !mirrored_;
    frame_ = frame_along(group_.direction, origin, mirrored_);
    project_leaves(frame_);
  }
  return true;
}

// Collects the leaves of B whose boxes meet the box, except that rounding may leave out some which only touch it.
void Patch::leaves_within(const Box& box) {
  leaves_.clear();
  open_nodes_.assign(1, Bvh::kRoot);
  while (!open_nodes_.empty() && leaves_.size() <= kMaxGrounds) {
    const WideNode& node = target_.nodes()[open_nodes_.back()];
    open_nodes_.pop_back();
    std::array<bool, kLanes> meets;
    meets.fill(true);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto low = static_cast<float>(box.low[static_cast<int>(k)] - node.origin[k]);
      const auto high = static_cast<float>(box.high[static_cast<int>(k)] - node.origin[k]);
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        meets[lane] = meets[lane] & (node.low[k][lane] <= high) & (node.high[k][lane] >= low);
      }
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      if (!meets[lane] || node.child[lane] == WideNode::kNone) continue;
      if (node.child[lane] & WideNode::kLeaf) {
        leaves_.push_back(node.child[lane] & ~WideNode::kLeaf);
      } else {
        open_nodes_.push_back(node.child[lane]);
      }
    }
  }
}

Patch::Extent Patch::extent_of(const PatchBlock& block) {
  return {-largest<-1>(block.low_x), largest<1>(block.high_x), -largest<-1>(block.low_y), largest<1>(block.high_y)};
}

// Returns how many triangles are seen from each side.
Orientations Patch::project_leaves(const PatchFrame& frame) {
  const MeshView mesh = target_.mesh();
  Orientations count{0, 0};
  ++gatherings_;
  for (std::size_t g = 0; g < ground_size_; ++g) {
    Ground& ground = grounds_[g];
    ground.number = leaves_[g];
    const std::uint32_t begin = Bvh::block_begin(ground.number), size = target_.block_end(ground.number) - begin;
    std::array<PointBlock, 3> corners;
    for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t t = begin + std::min(lane, size - 1);
      for (int i = 0; i < 3; ++i) put(mesh.corner(t, i), corners[static_cast<std::size_t>(i)], lane);
    }
    const Orientations seen = target_.kernels().project(corners.data(), frame, ground.block);
    const unsigned real = (1U << size) - 1;  // lanes beyond the last triangle repeat it
    const unsigned used = seen.left & real;
    gathered_[ground.number] = gatherings_ << kLanes | used;
    for (std::size_t lane = size; lane < kLanes; ++lane) ground.block.low_x[lane] = kPatchNowhere;
    ground.edges_known = false;
    extents_[g] = extent_of(ground.block);
    count.left += static_cast<unsigned>(std::popcount(used));
    count.right += static_cast<unsigned>(std::popcount(seen.right & real));
  }
  return count;
}

// Bounds the group's triangles, eight at a time.
void Patch::bound_group(MeshView from, std::span<const std::uint32_t> triangles, double limit, Work& work) {
  for (std::size_t begin = 0; begin < group_.members.size(); begin += kLanes) {
    const std::size_t size = std::min(kLanes, group_.members.size() - begin);
    std::array<PointBlock, 3> corners;
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const std::uint32_t t = triangles[group_.members[begin + std::min(lane, size - 1)]];
      put(from.corner(t, 0), corners[0], lane);
      put(from.corner(t, 1), corners[mirrored_ ? 2 : 1], lane);
      put(from.corner(t, 2), corners[mirrored_ ? 1 : 2], lane);
    }
    PatchBlock block;
    const unsigned usable = target_.kernels().project(corners.data(), frame_, block).left;
    find_near(block);
    for (std::size_t lane = 0; lane < size; ++lane) {
      if (usable >> lane & 1) bounds_[group_.members[begin + lane]] = bound(piece_of(block, lane), limit, work);
    }
  }
}

PatchPiece Patch::piece_of(const PatchBlock& block, std::size_t lane) {
  PatchPiece piece;
  piece.inner_x = piece.inner_y = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    piece.x[i] = block.x[i][lane];
    piece.y[i] = block.y[i][lane];
    piece.z[i] = block.z[i][lane];
    piece.inner_x += kInnerWeights[i] * piece.x[i];
    piece.inner_y += kInnerWeights[i] * piece.y[i];
  }
  piece.slope_x = block.slope_x[lane];
  piece.slope_y = block.slope_y[lane];
  piece.level = block.level[lane];
  piece.error = block.error[lane];
  piece.low_x = block.low_x[lane];
  piece.high_x = block.high_x[lane];
  piece.low_y = block.low_y[lane];
  piece.high_y = block.high_y[lane];
  return piece;
}

Patch::Bound Patch::bound(const PatchPiece& piece, double limit, Work& work) {
  const double width = std::max(piece.high_x - piece.low_x, piece.high_y - piece.low_y);
  if (!(width > rounding::kPatchNarrowest)) return {};
  const std::size_t hits = find_hits(piece);
  work.triangle_tests += hits * kLanes;
  Bound result{0, Nearest::kNone};
  for (std::size_t i = 0; i < hits; ++i) {
    Ground& ground = grounds_[hits_[i]];
    PatchCover cover = target_.kernels().cover(ground.block, piece, limit);
    result.upper = std::max(result.upper, cover.upper);
    if (cover.above != 0 && !bound_by_clipping(piece, ground, limit, cover, result)) return {};
    if (cover.near == 0) continue;
    if (meets_open_edge(piece, ground, cover.near)) return {};
    if (const unsigned inner = cover.inner & cover.near; inner != 0) {
      result.under = Bvh::block_begin(ground.number) + static_cast<std::uint32_t>(std::countr_zero(inner));
    }
  }
  if (result.under == Nearest::kNone) return {};
  result.upper += rounding::kPatchSlack;
  return result;
}

// Fills near_ with the grounds whose boxes meet that of the block.
void Patch::find_near(const PatchBlock& block) {
  const Extent box = extent_of(block);
  near_size_ = 0;
  for (std::size_t g = 0; g < ground_size_; ++g) {
    near_[near_size_] = static_cast<std::uint8_t>(g);
    near_size_ += meet(extents_[g], box);
  }
}

// Fills hits_ with those of near_ whose boxes meet that of the piece. Returns their number.
std::size_t Patch::find_hits(const PatchPiece& piece) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < near_size_; ++i) {
    hits_[count] = near_[i];
    count += meet(extents_[near_[i]], piece);
  }
  return count;
}

// Bounds the lanes that are above the limit, or finds that they are not near. False: one exceeds the limit.
bool Patch::bound_by_clipping(const PatchPiece& piece, const Ground& ground, double limit, PatchCover& cover,
                              Bound& result) {
  const View view(piece);
  for (unsigned left = cover.above; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(left));
    const auto [low, high] = view.gap(ground.block, lane);
    if (low > high || low > limit || high < -limit) {
      cover.near &= ~(1U << lane);
      continue;
    }
    const double upper = std::max(high, -low);
    if (upper > limit) return false;
    result.upper = std::max(result.upper, upper);
  }
  return true;
}

bool Patch::meets_open_edge(const PatchPiece& piece, Ground& ground, unsigned lanes) {
  if (!ground.edges_known) find_open_edges(ground);
  if ((lanes & (ground.open[0] | ground.open[1] | ground.open[2])) == 0) return false;
  const View view(piece);
  for (std::size_t edge = 0; edge < 3; ++edge) {
    for (unsigned left = lanes & ground.open[edge]; left != 0; left &= left - 1) {
      if (view.meets(ground.block, static_cast<std::size_t>(std::countr_zero(left)), edge)) return true;
    }
  }
  return false;
}

void Patch::find_open_edges(Ground& ground) {
  constexpr std::uint64_t kAll = (1U << kLanes) - 1;
  ground.open = {};
  for (std::uint64_t left = gathered_[ground.number] & kAll; left != 0; left &= left - 1) {
    const auto lane = static_cast<std::uint32_t>(std::countr_zero(left));
    for (std::uint32_t edge = 0; edge < 3; ++edge) {
      if (is_open(Bvh::block_begin(ground.number) + lane, edge)) ground.open[edge] |= 1U << lane;
    }
  }
  ground.edges_known = true;
}

bool Patch::is_open(std::uint32_t triangle, std::uint32_t edge) const {
  const auto partner = adjacency_.only_partner(triangle, edge);
  if (!partner || !gathered(partner->triangle)) return true;
  const MeshView mesh = target_.mesh();
  const std::uint32_t to = mesh.triangles[triangle][(edge + 1) % 3];
  const std::uint32_t partner_from = mesh.triangles[partner->triangle][partner->edge];
  return to != partner_from && mesh.positions[to] != mesh.positions[partner_from];  // both run in the same direction
}

bool Patch::gathered(std::uint32_t triangle) const {
  const std::uint64_t seen = gathered_[triangle / kLanes];
  return seen >> kLanes == gatherings_ && (seen >> triangle % kLanes & 1) != 0;
}

}  // namespace meshgauge
