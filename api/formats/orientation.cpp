#include "api/formats/orientation.h"

#include <algorithm>

namespace meshgauge::api {
namespace {

// a + b = sum + error, exactly (Knuth).
double sum_with_error(double a, double b, double& error) {
  const double sum = a + b;
  const double b_part = sum - a;
  error = (a - (sum - b_part)) + (b - b_part);
  return sum;
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

}  // namespace

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

}  // namespace meshgauge::api
