#include "api/map/colour_map.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

using namespace meshgauge;

namespace {

using Triple = std::array<double, 3>;
using Matrix = std::array<Triple, 3>;

double apart(const Triple& a, const Triple& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

// Colour vision of the three kinds of dichromats, on linear sRGB: Machado, Oliveira, Fernandes, "A
// physiologically-based model for simulation of color vision deficiency", 2009, at full severity; and the identity.
constexpr std::array<Matrix, 4> kEyes{{
    {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
    {{{0.152286, 1.052583, -0.204868}, {0.114503, 0.786281, 0.099216}, {-0.003882, -0.048116, 1.051998}}},
    {{{0.367322, 0.860646, -0.227968}, {0.280085, 0.672501, 0.047413}, {-0.011820, 0.042940, 0.968881}}},
    {{{1.255528, -0.076749, -0.178779}, {-0.078411, 0.930809, 0.147602}, {0.004733, 0.691367, 0.303900}}},
}};

std::uint8_t to_byte(double linear) {
  const double c = std::clamp(linear, 0.0, 1.0);
  return static_cast<std::uint8_t>(
      std::lround(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055)));
}

// OKLab: lightness from 0 to 1, green to red, blue to yellow; the matrices as published. The Euclidean distance is
// about how different two colours look.
Triple to_oklab(api::Rgb colour) {
  const auto c = api::to_linear(colour);
  const double l = std::cbrt(0.4122214708 * c[0] + 0.5363325363 * c[1] + 0.0514459929 * c[2]);
  const double m = std::cbrt(0.2119034982 * c[0] + 0.6806995451 * c[1] + 0.1073969566 * c[2]);
  const double s = std::cbrt(0.0883024619 * c[0] + 0.2817188376 * c[1] + 0.6299787005 * c[2]);
  return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
          1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
          0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

Triple seen(api::Rgb colour, const Matrix& eye) {
  const auto c = api::to_linear(colour);
  std::array<std::uint8_t, 3> bytes{};
  for (std::size_t i = 0; i < 3; ++i) bytes[i] = to_byte(eye[i][0] * c[0] + eye[i][1] * c[1] + eye[i][2] * c[2]);
  return to_oklab({bytes[0], bytes[1], bytes[2]});
}

std::vector<double> values(const std::vector<api::Tick>& ticks) {
  std::vector<double> all;
  for (const auto& tick : ticks) all.push_back(tick.value);
  return all;
}

}  // namespace

TEST_CASE("equal steps of the map look equal, in lightness and in colour") {
  constexpr int kSteps = 32;
  const double rise = (to_oklab(api::map_colour(1))[0] - to_oklab(api::map_colour(0))[0]) / kSteps;
  CHECK(rise * kSteps > 0.65);  // 1: from black to white
  double least = 1, most = 0;
  for (int i = 0; i < kSteps; ++i) {
    const Triple a = to_oklab(api::map_colour(double(i) / kSteps));
    const Triple b = to_oklab(api::map_colour(double(i + 1) / kSteps));
    CHECK(b[0] - a[0] == doctest::Approx(rise).epsilon(0.15));  // bytes are coarse for dark colours
    least = std::min(least, apart(a, b));
    most = std::max(most, apart(a, b));
  }
  CHECK(most < 1.25 * least);
}

TEST_CASE("the order of the map is visible with every kind of colour blindness") {
  for (const Matrix& eye : kEyes) {
    for (int i = 0; i < 32; ++i) {
      const double step = apart(seen(api::map_colour(i / 32.0), eye), seen(api::map_colour((i + 1) / 32.0), eye));
      CHECK(step > 0.4 / 32);
    }
  }
}

TEST_CASE("the colour above the limit is far from all colours below it, with every kind of colour blindness") {
  for (const Matrix& eye : kEyes) {
    double least = 1;
    for (int i = 0; i <= 256; ++i) {
      least = std::min(least, apart(seen(api::map_colour(i / 256.0), eye), seen(api::kAboveLimit, eye)));
    }
    CHECK(least > 0.15);  // more than six steps of 1/32
  }
  const double jump = to_oklab(api::map_colour(1))[0] - to_oklab(api::kAboveLimit)[0];
  CHECK(jump > 0.4);  // lightness jumps at the limit, which shows in greyscale as well
}

TEST_CASE("a distance has its place in the map, and the limit itself passes") {
  const api::ColourScale scale{0.5, true};
  CHECK(api::colour_of(0, scale) == api::map_colour(0));
  CHECK(api::colour_of(0.25, scale) == api::map_colour(0.5));
  CHECK(api::colour_of(0.5, scale) == api::map_colour(1));
  CHECK(api::colour_of(std::nextafter(0.5, 1), scale) == api::kAboveLimit);
  CHECK(api::colour_of(std::numeric_limits<double>::infinity(), scale) == api::kAboveLimit);
  CHECK(api::colour_of(0.6, {0.5, false}) == api::map_colour(1));
  CHECK(api::colour_of(0, {0, true}) == api::map_colour(0));
  CHECK(api::colour_of(5e-324, {0, true}) == api::kAboveLimit);
  CHECK(api::colour_of(5e-324, {0, false}) == api::map_colour(1));
  CHECK(api::map_colour(std::nan("")) == api::map_colour(0));
}

TEST_CASE("linear light is that of sRGB") {
  CHECK(api::to_linear({0, 255, 0}) == std::array<float, 3>{0, 1, 0});
  CHECK(api::to_linear({188, 0, 0})[0] == doctest::Approx(0.5029).epsilon(0.001));
  CHECK(to_oklab({255, 255, 255})[0] == doctest::Approx(1).epsilon(1e-6));
}

TEST_CASE("ticks are round numbers, and the top") {
  CHECK(values(api::legend_ticks({0.5, true})) == std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5});
  CHECK(values(api::legend_ticks({0.05, true})) == std::vector<double>{0, 0.01, 0.02, 0.03, 0.04, 0.05});
  CHECK(values(api::legend_ticks({1, true})) == std::vector<double>{0, 0.2, 0.4, 0.6, 0.8, 1});
  CHECK(values(api::legend_ticks({0.61, true})) == std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.61});
  CHECK(values(api::legend_ticks({2e20, true})).back() == 2e20);
  CHECK(values(api::legend_ticks({0, true})) == std::vector<double>{0});
  CHECK(api::legend_ticks({0.3, true})[1].label == "0.05");
  for (double top = 1e-9; top < 1e9; top *= 1.37) {
    const auto ticks = api::legend_ticks({top, true});
    CHECK(ticks.size() >= 4);
    CHECK(ticks.size() <= 8);
    CHECK(ticks.back().value == top);
    CHECK(std::is_sorted(ticks.begin(), ticks.end(), [](const auto& a, const auto& b) { return a.value < b.value; }));
  }
}

// The page implements the same map and rule; its own test reads the same file.
TEST_CASE("the page has the same colours and ticks") {
  std::ifstream file(MESHGAUGE_SOURCE_DIR "/tests/web/unit/colours.json");
  const auto reference = nlohmann::json::parse(file);
  const auto hex = [](api::Rgb colour) {
    char text[8];
    std::snprintf(text, sizeof text, "%02x%02x%02x", colour.red, colour.green, colour.blue);
    return std::string(text);
  };
  std::string colours;
  for (const auto& row : reference["colours"]) colours += row.get<std::string>();
  REQUIRE(colours.size() == 257 * 6);
  for (std::size_t i = 0; i <= 256; ++i) {
    CHECK(hex(api::map_colour(static_cast<double>(i) / 256)) == colours.substr(6 * i, 6));
  }
  CHECK(hex(api::kAboveLimit) == reference["above"].get<std::string>());
  REQUIRE(reference["ticks"].size() >= 10);
  for (const auto& row : reference["ticks"]) {
    CHECK(values(api::legend_ticks({row["top"].get<double>(), true})) == row["values"].get<std::vector<double>>());
  }
}
