#include "check/html/strip.h"

#include <cstddef>
#include <string_view>

#include "check/html/render.h"

namespace meshgauge::check {
namespace {

constexpr Pixel kPaper{244, 246, 248, 255}, kPanel{255, 255, 255, 255}, kLabel{86, 96, 107, 255};
constexpr int kGap = 8;  // around each view, in pixels
constexpr int kLabelRow = kLetterHeight + 2 * kGap;
constexpr double kTranslucent = 0.4;
constexpr float kSameSurface = 2;  // difference of depths up to which two surfaces are one, in pixels

constexpr int left_of(int index) { return kGap + index * (kStripViewWidth + kGap); }

Rendered layer_of(const StripScene& scene, const StripMesh& side, bool with_distance, ThreadPool& pool) {
  Paint paint{{}, scene.scale, inside_of(side.mesh, scene.camera)};
  if (with_distance) paint.distance = side.distance;
  return render_with_depth(side.mesh, scene.camera, paint, pool);
}

// `share`: of the colour, beside its own alpha.
void lay_pixel(Image& panel, const Image& from, std::size_t at, double share) {
  const Pixel colour{from.rgba[at], from.rgba[at + 1], from.rgba[at + 2], from.rgba[at + 3]};
  if (colour[3] > 0) lay_over(panel, at, colour, share);
}

Image blank_panel() { return blank_image(kStripViewWidth, kStripViewHeight, kPanel); }

Image panel_of(const Image& view) {
  Image panel = blank_panel();
  for (std::size_t at = 0; at < view.rgba.size(); at += 4) lay_pixel(panel, view, at, 1);
  return panel;
}

// `behind` is translucent, also where it is nearer to the viewer.
Image both_of(const Rendered& shown, const Rendered& behind) {
  Image panel = blank_panel();
  for (std::size_t at = 0; at < panel.rgba.size(); at += 4) {
    const bool is_before = behind.depth[at / 4] > shown.depth[at / 4] + kSameSurface;
    if (!is_before) lay_pixel(panel, behind.image, at, kTranslucent);
    lay_pixel(panel, shown.image, at, 1);
    if (is_before) lay_pixel(panel, behind.image, at, kTranslucent);
  }
  return panel;
}

Image difference_of(const StripScene& scene, const Rendered& before, const Rendered& after, ThreadPool& pool) {
  const auto coloured = [&](const StripMesh& side) { return layer_of(scene, side, true, pool); };
  const bool by_baseline = !scene.candidate.distance && scene.baseline.distance;
  Image panel = by_baseline               ? both_of(coloured(scene.baseline), after)
                : scene.baseline.distance ? both_of(coloured(scene.candidate), coloured(scene.baseline))
                                          : both_of(coloured(scene.candidate), before);
  if (scene.mark) draw_mark(panel, *scene.mark);
  return panel;
}

void set_panel(Image& strip, const Image& panel, int index, std::string_view label) {
  for (int y = 0; y < panel.height; ++y) {
    for (int x = 0; x < panel.width; ++x) {
      const std::size_t from = panel.at(x, y), to = strip.at(left_of(index) + x, kLabelRow + y);
      for (std::size_t k = 0; k < 3; ++k) strip.rgba[to + k] = to_level(panel.rgba[from + k]);
    }
  }
  write_word(strip, left_of(index), kGap, label, kLabel);
}

}  // namespace

Image strip_of(const StripScene& scene, ThreadPool& pool) {
  Image strip = blank_image(left_of(3), kLabelRow + kStripViewHeight + kGap, kPaper);
  const Rendered before = layer_of(scene, scene.baseline, false, pool);
  const Rendered after = layer_of(scene, scene.candidate, false, pool);
  set_panel(strip, panel_of(before.image), 0, "before");
  set_panel(strip, panel_of(after.image), 1, "after");
  set_panel(strip, difference_of(scene, before, after, pool), 2, "difference");
  return strip;
}

}  // namespace meshgauge::check
