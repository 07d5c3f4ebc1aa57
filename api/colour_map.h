// Distances as colours: one map for deviation files, pictures and their legends.
//
// Up to the limit: a helix in OKLab (B. Ottosson, "A perceptual color space for image processing", 2020), from dark
// violet at 0 over blue, teal and green to light yellow at the limit. Lightness rises evenly and hue turns evenly, so
// equal steps of distance look equal, in grey and to the colour-blind as well. Above the limit: one dark red, far from
// every colour of the map for all three kinds of colour-blindness.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace meshgauge::api {

// sRGB, as screens and PLY have it.
struct Rgb {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  bool operator==(const Rgb&) const = default;
};

inline constexpr Rgb kAboveLimit{190, 12, 0};

// What the ends of the map stand for.
struct ColourScale {
  double top = 0;       // distance of the last colour; >= 0
  bool limited = true;  // `top` is a limit: beyond it kAboveLimit. Else the largest distance there is.
};

// The map itself; `share` of its length is clamped to [0, 1], NaN is 0.
Rgb map_colour(double share);

// Precondition: distance >= 0. With a top of 0 only 0 is within the limit.
Rgb colour_of(double distance, const ColourScale& scale);

// The same colours in linear light of the sRGB primaries, from 0 to 1, as glTF has them.
std::array<float, 3> to_linear(Rgb colour);

struct Tick {
  double value = 0;   // in the meshes' unit, within [0, top]
  std::string label;  // shortest decimal: "0.05"
};

// Round numbers 1, 2 or 5 times a power of ten apart, from 0, three to seven of them, and the top at the end; a round
// number so near the top that their labels would touch is left out. Only 0 where the top is 0.
std::vector<Tick> legend_ticks(const ColourScale& scale);

}  // namespace meshgauge::api
