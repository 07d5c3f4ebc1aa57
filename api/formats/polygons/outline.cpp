#include "api/formats/polygons/outline.h"

#include <algorithm>
#include <iterator>
#include <vector>

namespace meshgauge::api {
namespace {

// a + b = sum + error, exactly (Knuth).
double sum_with_error(double a, double b, double& error) {
  const double sum = a + b;
  const double b_part = sum - a;
  error = (a - (sum - b_part)) + (b - b_part);
  return sum;
}

// An unrounded sum of doubles and of products of two doubles: an expansion of parts that do not overlap, smallest first
// (Shewchuk 1997, grow-expansion). Exact while no product overflows and no nonzero product is below 2^-960.
class ExactSum {
 public:
  void add(double x);
  void add_product(double a, double b);
  int sign() const { return parts_.empty() ? 0 : (parts_.back() > 0 ? 1 : -1); }

 private:
  std::vector<double> parts_;
};

void ExactSum::add(double x) {
  std::size_t kept = 0;
  for (const double part : parts_) {
    double error = 0;
    x = sum_with_error(x, part, error);
    if (error != 0) parts_[kept++] = error;
  }
  parts_.resize(kept);
  if (x != 0) parts_.push_back(x);
}

void ExactSum::add_product(double a, double b) {
  const double product = a * b;
  add(std::fma(a, b, -product));
  add(product);
}

double size_of(const Point2& p) { return std::max(std::abs(p.x), std::abs(p.y)); }

// Scales coordinates to at most 1, so that products neither overflow nor lose bits.
class Scale {
 public:
  explicit Scale(double largest) { std::frexp(largest, &exponent_); }

  Point2 operator()(const Point2& p) const { return {scaled(p.x), scaled(p.y)}; }

 private:
  double scaled(double x) const {
    constexpr double kTiny = 0x1p-400;
    const double y = std::ldexp(x, -exponent_);
    return std::abs(y) < kTiny ? 0 : y;
  }

  int exponent_ = 0;
};

void add_cross(ExactSum& sum, const Point2& a, const Point2& b) {
  sum.add_product(a.x, b.y);
  sum.add_product(-a.y, b.x);
}

int sign_of(double x) { return x > 0 ? 1 : (x < 0 ? -1 : 0); }

// Returns the sign of ab - cd, for exact factors. Equal products round to the same number, and rounding keeps the order
// of different ones.
int compare_products(double a, double b, double c, double d) {
  const double left = a * b, right = c * d;
  if (left != right) return sign_of(left - right);
  return sign_of(std::fma(a, b, -left) - std::fma(c, d, -right));
}

struct Edge {
  Point2 from, to;

  double low_x() const { return std::min(from.x, to.x); }
  double high_x() const { return std::max(from.x, to.x); }
  double low_y() const { return std::min(from.y, to.y); }
  double high_y() const { return std::max(from.y, to.y); }
};

bool may_cross(const Edge& a, const Edge& b) { return a.low_y() <= b.high_y() && b.low_y() <= a.high_y(); }

bool cross(const Edge& a, const Edge& b) {
  return orientation(a.from, a.to, b.from) * orientation(a.from, a.to, b.to) < 0 &&
         orientation(b.from, b.to, a.from) * orientation(b.from, b.to, a.to) < 0;
}

bool goes_up(const Point2& a, const Point2& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); }

}  // namespace

int exact_orientation(const Point2& a, const Point2& b, const Point2& c) {
  const Scale scale(std::max({size_of(a), size_of(b), size_of(c)}));
  const Point2 p = scale(a), q = scale(b), r = scale(c);
  // Most collinear points have coordinates of few digits, whose differences are exact.
  double errors[4] = {};
  const double px = sum_with_error(p.x, -r.x, errors[0]), py = sum_with_error(p.y, -r.y, errors[1]);
  const double qx = sum_with_error(q.x, -r.x, errors[2]), qy = sum_with_error(q.y, -r.y, errors[3]);
  if (std::all_of(std::begin(errors), std::end(errors), [](double e) { return e == 0; })) {
    return compare_products(px, qy, py, qx);
  }
  ExactSum sum;
  add_cross(sum, p, q);
  add_cross(sum, q, r);
  add_cross(sum, r, p);
  return sum.sign();
}

int area_sign(std::span<const Point2> outline) {
  double largest = 0;
  for (const Point2& p : outline) largest = std::max(largest, size_of(p));
  const Scale scale(largest);
  ExactSum sum;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    add_cross(sum, scale(outline[i]), scale(outline[i + 1 == outline.size() ? 0 : i + 1]));
  }
  return sum.sign();
}

// Convex: all turns are one way, and the edges change only twice between going up and going down the lexicographic
// order (with three or more changes the outline winds several times or runs back on itself). Two changes with a
// reversal, a turn by 180 degrees, among turns to the left need all edges after it to go down until it is closed, so
// there is no area.
Turns turns_of(std::span<const Point2> outline) {
  std::vector<Point2> corners;  // without repetitions
  corners.reserve(outline.size());
  for (const Point2& p : outline) {
    if (corners.empty() || !(p == corners.back())) corners.push_back(p);
  }
  while (corners.size() > 1 && corners.back() == corners.front()) corners.pop_back();
  const std::size_t n = corners.size();
  std::size_t left = 0, right = 0, changes = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point2 &a = corners[i], &b = corners[(i + 1) % n], &c = corners[(i + 2) % n];
    const int turn = orientation(a, b, c);
    left += turn > 0;
    right += turn < 0;
    changes += goes_up(a, b) != goes_up(b, c);
  }
  const bool one_way = left == 0 || right == 0;
  const bool on_one_line = left == 0 && right == 0;
  return {on_one_line || (one_way && changes == 2), !one_way};
}

bool crosses_itself(std::span<const Point2> outline, StepBudget& budget) {
  const std::size_t n = outline.size();
  std::vector<Edge> edges;
  edges.reserve(n);
  for (std::size_t i = 0; i < n; ++i) edges.push_back({outline[i], outline[i + 1 == n ? 0 : i + 1]});
  // Stable, so that equal edges come in the same order everywhere: the budget counts the pairs up to the first
  // crossing.
  std::stable_sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.low_x() < b.low_x(); });
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n && edges[j].low_x() <= edges[i].high_x(); ++j) {
      const bool near = may_cross(edges[i], edges[j]);
      if (!budget.spend(near ? 1 + kOrientationSteps : 1)) return false;
      if (near && cross(edges[i], edges[j])) return true;
    }
  }
  return false;
}

}  // namespace meshgauge::api
