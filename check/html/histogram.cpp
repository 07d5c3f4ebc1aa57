#include "check/html/histogram.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <Eigen/Geometry>

#include "check/html/markup.h"
#include "check/text.h"
#include "engine/mesh/frame.h"

namespace meshgauge::check {
namespace {

constexpr double kMagnitudes = 15;   // ratio of largest to smallest from which a linear axis would hide the small ones
constexpr double kNeighbours = 0.8;  // ratio of smallest to largest from which the axis shows their neighbourhood
constexpr std::size_t kMostTicks = 7;

// Whether an axis can show the number; the limits leave room for the arithmetic.
bool shown(double x) { return x > 1e-300 && x < 1e300; }

std::vector<AxisTick> linear_ticks(const Axis& axis) {
  std::vector<AxisTick> ticks;
  const double step = svg::round_length((axis.high - axis.low) / 3);  // gives two to six ticks
  const double first = std::ceil(axis.low / step);
  for (double i = first; i * step <= axis.high && ticks.size() < kMostTicks; ++i) {
    ticks.push_back({i * step, to_digits(i * step, 9)});
  }
  return ticks;
}

// Powers of ten, with their 2- and 5-fold if there is room.
std::vector<AxisTick> logarithmic_ticks(const Axis& axis) {
  std::vector<AxisTick> ticks;
  const double first = std::floor(std::log10(axis.low)), last = std::floor(std::log10(axis.high));
  const double step = std::max(1.0, std::ceil((last - first) / static_cast<double>(kMostTicks)));
  for (double i = first; i <= last; i += step) {
    for (const double digit : {1, 2, 5}) {
      const double value = digit * std::pow(10, i);
      if (value < axis.low || value > axis.high || (digit > 1 && last - first > 2)) continue;
      ticks.push_back({value, to_digits(value, 9)});
    }
  }
  return ticks;
}

constexpr std::size_t kBins = 48;
constexpr std::size_t kPointsATask = 512;
constexpr double kFewMagnitudes = 25;    // ratio of top to median up to which a linear axis shows the shape
constexpr double kMostMagnitudes = 1e7;  // shown below the top

// The k-th point of the R2 sequence, folded into the triangle: evenly distributed for any range of k.
Vec3 point_in(MeshView mesh, std::size_t triangle, std::size_t k) {
  double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(k), 1.0);
  double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(k), 1.0);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  const Vec3& a = mesh.corner(triangle, 0);
  return a + u * (mesh.corner(triangle, 1) - a) + v * (mesh.corner(triangle, 2) - a);
}

// In a frame, so that squares neither overflow nor vanish.
double area(MeshView mesh, const Frame& frame, std::size_t triangle) {
  const Vec3 a = frame.to_frame(mesh.corner(triangle, 0));
  const Vec3 u = frame.to_frame(mesh.corner(triangle, 1)) - a, v = frame.to_frame(mesh.corner(triangle, 2)) - a;
  return 0.5 * u.cross(v).norm();
}

double quantile(const std::vector<double>& sorted, double share) {
  return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
}

// Starts at 0, or is logarithmic where most of the surface would fall into the first bin.
Axis axis_of(const std::vector<double>& sorted, double limit) {
  const double top = 1.2 * std::max(limit, sorted.back());
  if (!(top > 1e-290 && top < 1e300)) return {};
  const double median = quantile(sorted, 0.5);
  if (median <= 0 || top <= kFewMagnitudes * median) return {false, 0, top};
  return {true, std::max(0.5 * quantile(sorted, 0.02), top / kMostMagnitudes), 2 * top};
}

// All of them, or `count` of them as far apart as can be.
std::vector<Vec3> points_of_cloud(MeshView cloud, std::size_t count) {
  const std::size_t all = cloud.triangles.size(), taken = std::min(all, count);
  std::vector<Vec3> points;
  points.reserve(taken);
  for (std::size_t i = 0; i < taken; ++i) points.push_back(cloud.corner(i * all / taken, 0));
  return points;
}

void count(Histogram& histogram, const std::vector<double>& distances) {
  histogram.shares.assign(kBins, 0);
  for (const double distance : distances) {
    const auto bin = static_cast<std::size_t>(histogram.axis.at(distance) * kBins);
    histogram.shares[std::min(bin, kBins - 1)] += 1 / static_cast<double>(distances.size());
  }
}

}  // namespace

double Axis::at(double x) const {
  if (!(x > low)) return 0;
  if (!(x < high)) return 1;
  if (!logarithmic) return (x - low) / (high - low);
  return (std::log(x) - std::log(low)) / (std::log(high) - std::log(low));  // high / low could overflow
}

double Axis::value(double share) const {
  if (!logarithmic) return low + share * (high - low);
  return std::exp((1 - share) * std::log(low) + share * std::log(high));
}

Axis axis_for(std::span<const double> values) {
  std::vector<double> counted;
  std::copy_if(values.begin(), values.end(), std::back_inserter(counted), shown);
  if (counted.empty()) return {};
  const auto [least, most] = std::minmax_element(counted.begin(), counted.end());
  const bool all = counted.size() == values.size();
  if (all && *least > kNeighbours * *most) {
    const double room = std::max(0.8 * (*most - *least), 0.01 * *most);
    return {false, *least - room, *most + room};
  }
  if (*most > kMagnitudes * *least) return {true, *least / 2.5, *most * 2.5};
  return {false, 0, 1.25 * *most};
}

std::vector<AxisTick> ticks(const Axis& axis) {
  return axis.logarithmic ? logarithmic_ticks(axis) : linear_ticks(axis);
}

std::vector<Vec3> spread_points(MeshView mesh, std::size_t count) {
  if (is_cloud(mesh)) return points_of_cloud(mesh, count);
  const Frame frame(bounding_box(mesh));
  double whole = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) whole += area(mesh, frame, t);
  std::vector<Vec3> points;
  if (!(whole > 0)) return points;
  points.reserve(count);
  const double step = whole / static_cast<double>(count);
  double passed = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    passed += area(mesh, frame, t);
    while (points.size() < count && (static_cast<double>(points.size()) + 0.5) * step < passed) {
      points.push_back(point_in(mesh, t, points.size()));
    }
  }
  return points;
}

Histogram histogram_of(MeshView mesh, const std::function<double(const Vec3&)>& distance, double limit,
                       std::size_t points, ThreadPool& pool) {
  const std::vector<Vec3> places = spread_points(mesh, points);
  Histogram histogram;
  histogram.points = places.size();
  histogram.of_cloud = is_cloud(mesh);
  histogram.all_points = places.size() == mesh.triangles.size();
  if (places.empty()) return histogram;
  std::vector<double> distances(places.size());
  pool.run((places.size() + kPointsATask - 1) / kPointsATask, [&](std::size_t, std::size_t task) {
    const std::size_t end = std::min(places.size(), (task + 1) * kPointsATask);
    for (std::size_t i = task * kPointsATask; i < end; ++i) distances[i] = distance(places[i]);
  });
  std::sort(distances.begin(), distances.end());
  const auto within = std::upper_bound(distances.begin(), distances.end(), limit);
  histogram.above_limit = static_cast<double>(distances.end() - within) / static_cast<double>(distances.size());
  histogram.median = quantile(distances, 0.5);
  histogram.p95 = quantile(distances, 0.95);
  histogram.largest = distances.back();
  histogram.axis = axis_of(distances, limit);
  count(histogram, distances);
  return histogram;
}

}  // namespace meshgauge::check
