// Maps distances to colours: one map for deviation files, pictures and their legends.
//
// Up to the limit: a helix in OKLab (B. Ottosson, "A perceptual color space for image processing", 2020), from dark
// violet at 0 through blue, teal and green to light yellow at the limit. Lightness rises evenly and hue turns evenly,
// so that equal steps of distance look equal, also in greyscale and with colour blindness. Above the limit: one dark
// red, far from every colour of the map for all three kinds of colour blindness.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace meshgauge::api {

// A colour in sRGB, as on screens and in PLY.
struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  bool operator==(const Rgb&) const = default;
};

inline constexpr Rgb kAboveLimit{190, 12, 0};

// The distances at the ends of the map; the first is 0.
struct ColourScale {
  double top = 0;  // distance of the last colour; >= 0
  bool limited =
      true;  // true: `top` is a limit, larger distances are kAboveLimit; false: `top` is the largest distance
};

// Returns the colour at `share` of the map's length, clamped to [0, 1]; NaN counts as 0.
Rgb map_colour(double share);

// Returns the colour of a distance. Precondition: distance >= 0. With a top of 0, only 0 is within the limit.
Rgb colour_of(double distance, const ColourScale& scale);

// Converts to linear light of the sRGB primaries, as in glTF; components from 0 to 1.
std::array<float, 3> to_linear(Rgb colour);

struct Tick {
  double value = 0;   // in the meshes' unit, within [0, top]
  std::string label;  // shortest decimal: "0.05"
};

// Returns the ticks of a legend: three to seven multiples of 1, 2 or 5 times a power of ten, from 0, then the top.
// Leaves out a multiple whose label would touch that of the top. Returns 0 alone when the top is 0.
std::vector<Tick> legend_ticks(const ColourScale& scale);

}  // namespace meshgauge::api
