#include "check/html/image.h"

#include <png.h>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <new>
#include <string_view>

namespace meshgauge::check {
namespace {

constexpr std::size_t kAfterHeader = kMarkedBytes - kMarkBytes;  // the signature, and the chunk IHDR
// A chunk of a PNG: the length of its content, type, content, CRC-32.
constexpr std::string_view kMark("\0\0\0\x12tEXtSoftware\0meshgauge\xC6\xF3\xE5\x9C", kMarkBytes);

constexpr Pixel kMarkCasing{255, 255, 255, 230}, kMarkInk{20, 24, 30, 255};
constexpr double kMarkRing = 9, kMarkArm = 7;                  // radius, and length of an arm outside of it
constexpr double kInkHalfWidth = 1.1, kCasingHalfWidth = 2.4;  // in pixels, as those before

// Rows of five dots from the top, the highest bit on the left.
struct Glyph {
  char letter;
  std::array<std::uint8_t, 7> rows;
};
constexpr Glyph kGlyphs[] = {
    {'a', {0x00, 0x00, 0x0E, 0x01, 0x0F, 0x11, 0x0F}}, {'b', {0x10, 0x10, 0x16, 0x19, 0x11, 0x11, 0x1E}},
    {'c', {0x00, 0x00, 0x0E, 0x10, 0x10, 0x11, 0x0E}}, {'d', {0x01, 0x01, 0x0D, 0x13, 0x11, 0x11, 0x0F}},
    {'e', {0x00, 0x00, 0x0E, 0x11, 0x1F, 0x10, 0x0E}}, {'f', {0x06, 0x09, 0x08, 0x1C, 0x08, 0x08, 0x08}},
    {'i', {0x04, 0x00, 0x0C, 0x04, 0x04, 0x04, 0x0E}}, {'n', {0x00, 0x00, 0x16, 0x19, 0x11, 0x11, 0x11}},
    {'o', {0x00, 0x00, 0x0E, 0x11, 0x11, 0x11, 0x0E}}, {'r', {0x00, 0x00, 0x16, 0x19, 0x10, 0x10, 0x10}},
    {'t', {0x08, 0x08, 0x1C, 0x08, 0x08, 0x09, 0x06}}};
constexpr int kDot = kLetterHeight / 7;  // pixels
constexpr int kGlyphDots = 5, kDotsALetter = 6;

void put(Image& image, std::size_t at, const Pixel& colour) {
  std::copy(colour.begin(), colour.end(), image.rgba.begin() + static_cast<std::ptrdiff_t>(at));
}

void write_glyph(Image& image, int x, int y, const Glyph& glyph, const Pixel& colour) {
  for (int row = 0; row < kLetterHeight; ++row) {
    for (int column = 0; column < kGlyphDots * kDot; ++column) {
      const unsigned dots = glyph.rows[static_cast<std::size_t>(row / kDot)];
      if ((dots >> static_cast<unsigned>(kGlyphDots - 1 - column / kDot)) & 1U)
        put(image, image.at(x + column, y + row), colour);
    }
  }
}

// Distance in pixels from the lines of the mark around the origin.
double from_mark(double x, double y) {
  const double ring = std::abs(std::hypot(x, y) - kMarkRing);
  const double along = std::max(std::abs(x), std::abs(y)), aside = std::min(std::abs(x), std::abs(y));
  const double beyond = std::max({kMarkRing - along, along - (kMarkRing + kMarkArm), 0.0});
  return std::min(ring, std::hypot(beyond, aside));
}

double covered_by(double half_width, double distance) { return std::clamp(half_width + 0.5 - distance, 0.0, 1.0); }

bool is_opaque(const Image& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba[i] != 255) return false;
  }
  return true;
}

std::vector<std::uint8_t> without_alpha(const Image& image) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(image.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    for (std::size_t k = 0; k < 3; ++k) rgb.push_back(image.rgba[i + k]);
  }
  return rgb;
}

// Each colour rounded to a multiple of `step`, a power of two.
Image coarser(Image image, int step) {
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    const int rounded = (image.rgba[i] + step / 2) / step * step;
    if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(std::min(rounded, 255));
  }
  return image;
}

Image half_of(const Image& image) {
  Image half = blank_image(std::max(image.width / 2, 1), std::max(image.height / 2, 1), {0, 0, 0, 255});
  for (int y = 0; y < half.height; ++y) {
    for (int x = 0; x < half.width; ++x) {
      const int right = std::min(2 * x + 1, image.width - 1), below = std::min(2 * y + 1, image.height - 1);
      const std::size_t from[] = {image.at(2 * x, 2 * y), image.at(right, 2 * y), image.at(2 * x, below),
                                  image.at(right, below)};
      for (std::size_t k = 0; k < 3; ++k) {
        int sum = 2;
        for (const std::size_t at : from) sum += image.rgba[at + k];
        half.rgba[half.at(x, y) + k] = static_cast<std::uint8_t>(sum / 4);
      }
    }
  }
  return half;
}

}  // namespace

std::uint8_t to_level(double channel) {
  return static_cast<std::uint8_t>(std::min(255L, 4 * std::lround(channel / 4)));
}

Image blank_image(int width, int height, const Pixel& colour) {
  Image image{width, height, {}};
  image.rgba.resize(image.at(0, height));
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) put(image, i, colour);
  return image;
}

void lay_over(Image& image, std::size_t at, const Pixel& colour, double share) {
  const double alpha = share * colour[3] / 255;
  for (std::size_t k = 0; k < 3; ++k) {
    const double under = image.rgba[at + k];
    image.rgba[at + k] = static_cast<std::uint8_t>(std::lround(under + alpha * (colour[k] - under)));
  }
}

void draw_mark(Image& image, const Seen& at) {
  constexpr double kReach = kMarkRing + kMarkArm + 4;
  if (!(std::abs(at.x) < 1e6 && std::abs(at.y) < 1e6)) return;
  const int left = std::max(static_cast<int>(at.x - kReach), 0), top = std::max(static_cast<int>(at.y - kReach), 0);
  const int right = std::min(static_cast<int>(at.x + kReach), image.width - 1);
  const int bottom = std::min(static_cast<int>(at.y + kReach), image.height - 1);
  for (int y = top; y <= bottom; ++y) {
    for (int x = left; x <= right; ++x) {
      const double distance = from_mark(x + 0.5 - at.x, y + 0.5 - at.y);
      lay_over(image, image.at(x, y), kMarkCasing, covered_by(kCasingHalfWidth, distance));
      lay_over(image, image.at(x, y), kMarkInk, covered_by(kInkHalfWidth, distance));
    }
  }
}

void write_word(Image& image, int x, int y, std::string_view word, const Pixel& colour) {
  for (const char letter : word) {
    const auto* const glyph = std::ranges::find(kGlyphs, letter, &Glyph::letter);
    if (glyph != std::end(kGlyphs)) write_glyph(image, x, y, *glyph, colour);
    x += kDotsALetter * kDot;
  }
}

std::vector<std::byte> to_png(const Image& image) {
  const bool opaque = is_opaque(image);
  const std::vector<std::uint8_t> rgb = opaque ? without_alpha(image) : std::vector<std::uint8_t>();
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::vector<std::byte> bytes(size);
  const void* const pixels = opaque ? rgb.data() : image.rgba.data();
  if (!png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, nullptr)) throw std::bad_alloc();
  bytes.resize(size);
  return bytes;
}

std::vector<std::byte> to_png_within(const Image& image, std::size_t bytes) {
  std::vector<std::byte> png = to_png(image);
  for (int step = 8; step <= 32 && png.size() > bytes; step *= 2) png = to_png(coarser(image, step));
  if (png.size() <= bytes || (image.width == 1 && image.height == 1)) return png;
  return to_png_within(half_of(image), bytes);
}

std::vector<std::byte> marked(std::vector<std::byte> png) {
  const auto mark = std::as_bytes(std::span(kMark));
  png.insert(png.begin() + kAfterHeader, mark.begin(), mark.end());
  return png;
}

bool is_marked(std::span<const std::byte> beginning) {
  return beginning.size() >= kMarkedBytes &&
         std::ranges::equal(beginning.subspan(kAfterHeader, kMarkBytes), std::as_bytes(std::span(kMark)));
}

}  // namespace meshgauge::check
