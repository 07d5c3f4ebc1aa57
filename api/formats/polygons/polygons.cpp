#include "api/formats/polygons/polygons.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <Eigen/Geometry>

#include "api/formats/polygons/ear_clipping.h"
#include "api/formats/polygons/polygon_deviation.h"

namespace meshgauge::api {
namespace {

Eigen::Index largest_axis(const Vec3& v) {
  Eigen::Index axis = 0;
  v.cwiseAbs().maxCoeff(&axis);
  return axis;
}

// Projects along `axis`; orientations may be mirrored.
Point2 seen_along(Eigen::Index axis, const Vec3& p) {
  if (axis == 0) return {p.y(), p.z()};
  return axis == 1 ? Point2{p.x(), p.z()} : Point2{p.x(), p.y()};
}

// Returns true when an outline of four corners certainly turns one way at each, by the error bound of orientation().
bool is_plainly_convex(const Point2& a, const Point2& b, const Point2& c, const Point2& d) {
  const Point2 ab = {b.x - a.x, b.y - a.y}, bc = {c.x - b.x, c.y - b.y};
  const Point2 cd = {d.x - c.x, d.y - c.y}, da = {a.x - d.x, a.y - d.y};
  const auto turn = [](const Point2& u, const Point2& v) {
    const double left = u.x * v.y, right = u.y * v.x;
    const double turned = left - right, error = kOrientationError * (std::abs(left) + std::abs(right)) + kLeastTurn;
    return turned > error ? 1 : (turned < -error ? -1 : 0);
  };
  return std::abs(turn(ab, bc) + turn(bc, cd) + turn(cd, da) + turn(da, ab)) == 4;
}

// Returns the face's normal with largest component 1; zero: all corners lie on one line. Scales edges to about 1 first,
// since products of tiny edges would underflow.
Vec3 normal_of(std::vector<Vec3> corners) {
  double extent = 0;
  for (const Vec3& p : corners) extent = std::max(extent, (p - corners[0]).cwiseAbs().maxCoeff());
  int exponent = 0;
  std::frexp(extent, &exponent);
  const Vec3 origin = corners[0];
  for (Vec3& p : corners) p = (p - origin).unaryExpr([&](double x) { return std::ldexp(x, -exponent); });
  // Without repetitions, all turns are 0 only on one line.
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  const std::size_t n = corners.size();
  const auto size = [](const Vec3& v) { return v.cwiseAbs().maxCoeff(); };
  Vec3 area = Vec3::Zero();  // twice the area along each axis (Newell)
  Vec3 sharpest = Vec3::Zero();
  const auto at_corner = [&](std::size_t i) -> Vec3 {
    const Vec3& p = corners[i];
    return (p - corners[(i + n - 1) % n]).cross(corners[(i + 1) % n] - p);
  };
  for (std::size_t i = 0; i < n; ++i) {
    area += corners[i].cross(corners[(i + 1) % n]);
    if (const Vec3 turn = at_corner(i); size(turn) > size(sharpest)) sharpest = turn;
  }
  // A face whose areas cancel, such as a polyline there and back, takes the plane at its sharpest corner.
  constexpr double kCancelled = 1e-9;
  const Vec3 normal = size(area) > kCancelled * size(sharpest) ? area : sharpest;
  return normal.isZero(0) ? normal : Vec3(normal / size(normal));
}

class Splitter {
 public:
  Splitter(ReadMesh& read, std::size_t steps) : mesh_(read.mesh), notes_(read.notes.polygons), budget_(steps) {}

  // false: the budget is spent.
  bool split(const FaceRun& run) {
    Triangle* triangles = mesh_.triangles.data() + run.first_triangle;
    for (std::size_t i = 0; i < run.faces; ++i, triangles += run.corners - 2) {
      ++notes_.count;
      if (run.corners == 4 && split_plain_quad(triangles)) continue;
      if (!split(triangles, run.corners)) return false;
    }
    return true;
  }

  std::uint32_t first_corner() const { return indices_[0]; }  // first vertex of the last face

 private:
  bool split_plain_quad(const Triangle* triangles);
  bool split(Triangle* triangles, std::size_t corners);
  bool clip(Triangle* triangles, bool crosses);
  void load(const Triangle* triangles, std::size_t corners);
  void measure(bool convex, bool simple);
  void note_deviation(double deviation) { notes_.largest_deviation = std::max(notes_.largest_deviation, deviation); }

  Mesh& mesh_;
  PolygonNotes& notes_;
  StepBudget budget_;
  StepBudget measuring_{kMeasureSteps};
  EarClipper clipper_{budget_};
  // The current face. Corners are scaled by 2^-exponent_ if they could overflow or underflow.
  std::vector<std::uint32_t> indices_;
  std::vector<Vec3> corners_;
  std::vector<Point2> outline_;
  int exponent_ = 0;
  Vec3 normal_;
};

// Splits a strictly convex quad, the most frequent face, which stays a fan. false: not certainly such a quad.
bool Splitter::split_plain_quad(const Triangle* triangles) {
  const std::vector<Vec3>& at = mesh_.positions;
  const Vec3 &a = at[triangles[0][0]], &b = at[triangles[0][1]], &c = at[triangles[0][2]], &d = at[triangles[1][2]];
  const Vec3 normal = (c - a).cross(d - b);
  const double normal_sq = squared_norm(normal);
  constexpr double kSmallest = 0x1p-400, kLargest = 0x1p400;
  if (!(normal_sq > kSmallest && normal_sq < kLargest)) return false;
  const Eigen::Index axis = largest_axis(normal);
  if (!is_plainly_convex(seen_along(axis, a), seen_along(axis, b), seen_along(axis, c), seen_along(axis, d))) {
    return false;
  }
  // The thickness times the normal's length: how far apart the diagonals are along the normal. Along the axis it bounds
  // the deviation (D1).
  const Vec3 ab = b - a;
  const double height = std::abs(dot(ab, normal)) + 0x1p-48 * dot(ab.cwiseAbs(), normal.cwiseAbs());
  if (height == 0) return true;
  const double largest = a.cwiseAbs().cwiseMax(b.cwiseAbs()).cwiseMax(c.cwiseAbs()).cwiseMax(d.cwiseAbs()).maxCoeff();
  const double planar = kPlanarThickness * largest;
  notes_.non_planar += height * height > planar * planar * normal_sq;
  const double so_far = notes_.largest_deviation;
  if (height > so_far * std::abs(normal[axis])) note_deviation(quad_deviation({a, b, c, d}, so_far, measuring_));
  return true;
}

void Splitter::load(const Triangle* triangles, std::size_t corners) {
  indices_.assign({triangles[0][0], triangles[0][1]});
  for (std::size_t i = 0; i < corners - 2; ++i) indices_.push_back(triangles[i][2]);
  double largest = 0;
  for (const std::uint32_t i : indices_) largest = std::max(largest, mesh_.positions[i].cwiseAbs().maxCoeff());
  std::frexp(largest, &exponent_);
  constexpr int kHarmless = 100;
  if (std::abs(exponent_) < kHarmless) exponent_ = 0;
  corners_.clear();
  for (const std::uint32_t i : indices_) {
    const Vec3& p = mesh_.positions[i];
    corners_.push_back(exponent_ == 0 ? p : Vec3(p.unaryExpr([&](double x) { return std::ldexp(x, -exponent_); })));
  }
}

bool Splitter::split(Triangle* triangles, std::size_t corners) {
  load(triangles, corners);
  normal_ = normal_of(corners_);
  if (normal_.isZero(0)) return true;  // on one line: every split is the segment
  const Eigen::Index axis = largest_axis(normal_);
  outline_.clear();
  for (const Vec3& p : corners_) outline_.push_back(seen_along(axis, p));
  const Turns turns = turns_of(outline_);
  bool simple = true;
  if (!turns.convex) {
    const bool crosses = crosses_itself(outline_, budget_);
    if (budget_.left() == 0 || !clip(triangles, crosses)) return false;
    simple = !crosses && !clipper_.gave_way();
    // The outline crosses itself at corners only.
    if (!simple && !crosses && !clip(triangles, true)) return false;
    notes_.self_crossing += !simple;
    notes_.concave += simple && turns.has_both;
  }
  measure(turns.convex, simple);
  return true;
}

bool Splitter::clip(Triangle* triangles, bool crosses) {
  const auto clipped = clipper_.clip(outline_, crosses);
  if (clipped.empty()) return false;
  for (const auto& ear : clipped) *triangles++ = {indices_[ear[0]], indices_[ear[1]], indices_[ear[2]]};
  return true;
}

// Notes the deviation. A face that crosses itself has no unique region; four corners that are not convex have one
// split.
void Splitter::measure(bool convex, bool simple) {
  double largest = 0;
  for (const Vec3& p : corners_) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  notes_.non_planar += thickness(corners_, normal_) > kPlanarThickness * largest;
  const double at_most = std::ldexp(deviation_along_axis(corners_, normal_), exponent_);
  if (!simple || at_most <= notes_.largest_deviation) return;
  double deviation = 0;
  if (corners_.size() == 4) {
    const std::array<Vec3, 4> quad = {corners_[0], corners_[1], corners_[2], corners_[3]};
    if (convex || diagonals_cross(quad)) deviation = quad_deviation(quad, 0, measuring_);
  } else {
    deviation = polygon_deviation(corners_, normal_, measuring_);
  }
  note_deviation(std::ldexp(deviation, exponent_));
}

}  // namespace

Result<Done> split_polygons(const Source& source, const std::vector<FaceRun>& runs, ReadMesh& read) {
  std::size_t corners = 0;
  for (const FaceRun& run : runs) corners += run.corners * run.faces;
  Splitter splitter(read, kSplitSteps + kStepsPerCorner * corners);
  for (const FaceRun& run : runs) {
    if (splitter.split(run)) continue;
    return at(source,
              "the face of " + std::to_string(run.corners) + " corners that begins with vertex " +
                  std::to_string(splitter.first_corner()) + " (counted from 0)",
              ErrorCode::too_large, "takes too long to split into triangles; split such faces into smaller ones first");
  }
  return Done{};
}

}  // namespace meshgauge::api
