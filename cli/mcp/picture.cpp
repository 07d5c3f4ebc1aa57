#include "cli/mcp/picture.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <span>
#include <utility>

#include "api/base/refused.h"
#include "check/html/picture.h"
#include "check/html/render.h"
#include "engine/thread_pool.h"

namespace meshgauge::mcp {
namespace {

constexpr double kRing = 14, kRingWidth = 5, kRingInk = 2;  // pixels: radius, whole width, that of its dark line

using check::Image;
using check::Seen;

Image image_in(std::span<const std::byte> png) {
  png_image read{};
  read.version = PNG_IMAGE_VERSION;
  if (!png_image_begin_read_from_memory(&read, png.data(), png.size())) throw std::bad_alloc();
  read.format = PNG_FORMAT_RGBA;
  Image image{static_cast<int>(read.width), static_cast<int>(read.height), {}};
  image.rgba.resize(std::size_t{4} * read.width * read.height);
  if (!png_image_finish_read(&read, nullptr, image.rgba.data(), 0, nullptr)) throw std::bad_alloc();
  return image;
}

// Shown on any background it looks the same.
void lay_on_white(Image& image) {
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const unsigned alpha = image.rgba[i + 3];
    for (std::size_t c = i; c < i + 3; ++c) {
      const unsigned colour = image.rgba[c];
      image.rgba[c] = static_cast<std::uint8_t>((colour * alpha + 255U * (255U - alpha)) / 255U);
    }
    image.rgba[i + 3] = 255;
  }
}

// A dark line between two light ones, to be seen on every colour.
void draw_ring(Image& image, const Seen& at) {
  const double reach = kRing + kRingWidth;
  for (int y = std::max(0, static_cast<int>(at.y - reach)); y < std::min<double>(image.height, at.y + reach); ++y) {
    for (int x = std::max(0, static_cast<int>(at.x - reach)); x < std::min<double>(image.width, at.x + reach); ++x) {
      const double off = std::abs(std::hypot(x + 0.5 - at.x, y + 0.5 - at.y) - kRing);
      if (off > kRingWidth / 2) continue;
      const std::size_t pixel =
          4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x));
      const auto shade = static_cast<std::uint8_t>(off > kRingInk / 2 ? 255 : 0);
      std::fill_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(pixel), 3, shade);
    }
  }
}

bool is_in(const Image& image, const Seen& at) {
  return at.x >= 0 && at.y >= 0 && at.x < image.width && at.y < image.height;
}

// Precondition: there is one.
const check::Surface& shown_surface(const check::GatePicture& picture, const check::Measured& measured) {
  const bool wanted = !measured.witness || measured.witness->on_candidate;
  const auto found = std::ranges::find(picture.surfaces, wanted, &check::Surface::candidate);
  return found == picture.surfaces.end() ? picture.surfaces.front() : *found;
}

Picture picture_with_ring(const check::Surface& surface) {
  Image image = image_in(surface.whole.png);
  lay_on_white(image);
  const std::optional<Seen>& from = surface.whole.from;
  const bool is_marked = from && is_in(image, *from);
  if (is_marked) draw_ring(image, *from);
  const char* const mesh = surface.candidate ? "a" : "b";
  Picture picture{to_png(image), {{"mesh", mesh}, {"width", image.width}, {"height", image.height}}, {}};
  picture.about["witness"] = is_marked ? Json{std::lround(from->x), std::lround(from->y)} : Json();
  picture.about["hidden"] = surface.whole.hidden;
  picture.words = std::string("the picture shows mesh ") + mesh +
                  ", coloured by its distance to the other mesh, from violet to yellow, dark red beyond that";
  if (is_marked)
    picture.words += std::string("; the ring is where it is farthest off") +
                     (surface.whole.hidden ? ", behind the surface that is seen" : "");
  return picture;
}

}  // namespace

Result<Picture> picture_of(const check::GateOutcome& outcome, const api::SharedMeshes& meshes, unsigned threads,
                           Control& control) try {
  const check::Measured& measured = *outcome.measured;
  const auto pair = api::in_unit_of_result(meshes.a, meshes.b, measured.units, measured.motion, control);
  if (!pair) return pair.error();
  ThreadPool pool(threads);
  const check::GatePicture made = check::make_picture(*pair->a, *pair->b, outcome, pool, control);
  if (made.surfaces.empty()) return refused(made.missing);
  return picture_with_ring(shown_surface(made, measured));
} catch (const std::bad_alloc&) {
  return refused("there is not enough memory for it");
} catch (const std::exception& error) {
  return refused(std::string("it could not be made: ") + error.what());
}

}  // namespace meshgauge::mcp
