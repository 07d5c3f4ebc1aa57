#include "api/map/colour_map.h"

#include <algorithm>
#include <cmath>

#include "api/base/figures.h"

namespace meshgauge::api {
namespace {

using Triple = std::array<double, 3>;

// The helix, found by a search over those inside sRGB: among the longest, the one whose colours stay farthest apart
// with colour blindness (tests/api/map/colour_map_test.cpp has the distances).
constexpr double kDarkest = 0.25;
constexpr double kLightest = 0.93;
constexpr double kCentreA = 0.02;
constexpr double kCentreB = 0.01;
constexpr double kChroma = 0.12;
constexpr double kFirstHue = 300;  // degrees
constexpr double kLastHue = 115;

Triple helix(double share) {
  const double hue = (kFirstHue + (kLastHue - kFirstHue) * share) * std::acos(-1.0) / 180;
  return {kDarkest + (kLightest - kDarkest) * share, kCentreA + kChroma * std::cos(hue),
          kCentreB + kChroma * std::sin(hue)};
}

double cube(double x) { return x * x * x; }

// Converts by OKLab's published matrices.
Triple oklab_to_linear(const Triple& lab) {
  const double l = cube(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2]);
  const double m = cube(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2]);
  const double s = cube(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2]);
  return {4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
          -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
          -0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s};
}

// The transfer functions of sRGB, IEC 61966-2-1.
std::uint8_t encoded(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  const double value = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
  return static_cast<std::uint8_t>(std::lround(255 * value));
}

double decoded(std::uint8_t byte) {
  const double c = byte / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

// A table, so that colouring a million vertices does not need a million powers.
constexpr std::size_t kSteps = 1024;
const std::array<Rgb, kSteps + 1>& table() {
  static const auto colours = [] {
    std::array<Rgb, kSteps + 1> made;
    for (std::size_t i = 0; i <= kSteps; ++i) {
      const Triple c = oklab_to_linear(helix(static_cast<double>(i) / kSteps));
      made[i] = {encoded(c[0]), encoded(c[1]), encoded(c[2])};
    }
    return made;
  }();
  return colours;
}

// Returns count * 10^exponent by one correctly rounded operation where possible: 3 * 10^-1 is 0.3.
double decimal(double count, int exponent) {
  return exponent < 0 ? count / std::pow(10, -exponent) : count * std::pow(10, exponent);
}

// The distance of ticks: digit * 10^exponent.
struct Step {
  double digit;
  int exponent;
};

// Returns a step that fits three to six times into `top`.
Step step_for(double top) {
  const int exponent = static_cast<int>(std::floor(std::log10(top))) - 1;
  for (const Step& step : {Step{1, exponent}, {2, exponent}, {5, exponent}, {1, exponent + 1}, {2, exponent + 1}}) {
    if (top / decimal(step.digit, step.exponent) < 6.5) return step;
  }
  return {5, exponent + 1};
}

}  // namespace

Rgb map_colour(double share) {
  const double within = share > 0 ? std::min(share, 1.0) : 0;
  return table()[static_cast<std::size_t>(std::lround(within * kSteps))];
}

Rgb colour_of(double distance, const ColourScale& scale) {
  if (distance <= 0) return map_colour(0);
  if (scale.limited && distance > scale.top) return kAboveLimit;
  return map_colour(distance / scale.top);
}

std::array<float, 3> to_linear(Rgb colour) {
  return {static_cast<float>(decoded(colour.red)), static_cast<float>(decoded(colour.green)),
          static_cast<float>(decoded(colour.blue))};
}

std::vector<Tick> legend_ticks(const ColourScale& scale) {
  std::vector<Tick> ticks{{0, "0"}};
  // Beyond these, powers of ten overflow or underflow; no mesh is that large or small.
  if (!(scale.top > 1e-290 && scale.top < 1e290)) return ticks;
  const Step step = step_for(scale.top);
  const double width = decimal(step.digit, step.exponent);
  for (int i = 1; i * width < scale.top - 0.4 * width; ++i) {
    const double value = decimal(i * step.digit, step.exponent);
    ticks.push_back({value, shortest(value)});
  }
  ticks.push_back({scale.top, shortest(scale.top)});
  return ticks;
}

}  // namespace meshgauge::api
