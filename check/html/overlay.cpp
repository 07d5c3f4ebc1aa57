#include <cmath>

#include "check/html/diagrams.h"
#include "check/html/markup.h"
#include "check/html/svg.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using svg::cased_line;
using svg::number;

bool inside(const Seen& seen, const Camera& camera) {
  return seen.x >= 0 && seen.y >= 0 && seen.x <= camera.width && seen.y <= camera.height;
}

std::string text_at(double x, double y, std::string_view css_class, const std::string& text) {
  return "<text class=\"" + std::string(css_class) + "\" x=\"" + number(x) + "\" y=\"" + number(y) + "\">" +
         escaped(text) + "</text>";
}

std::string circle(const Seen& at, double radius, std::string_view css_class) {
  return "<circle class=\"" + std::string(css_class) + "\" cx=\"" + number(at.x) + "\" cy=\"" + number(at.y) +
         "\" r=\"" + number(radius) + "\"/>";
}

// Cross hairs that leave the point itself visible; dashed if the part hides it.
std::string witness_mark(const Seen& at, bool hidden) {
  constexpr double kRadius = 11, kArm = 9;
  const std::string_view kind = hidden ? "mark hidden" : "mark";
  std::string out = circle(at, kRadius, "casing") + circle(at, kRadius, kind);
  for (const auto& [x, y] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
    out += cased_line(at.x + x * kRadius, at.y + y * kRadius, at.x + x * (kRadius + kArm), at.y + y * (kRadius + kArm),
                      "mark");
  }
  return out;
}

std::string reach_line(const Shot& shot) {
  if (std::hypot(shot.from->x - shot.to->x, shot.from->y - shot.to->y) < 3) return "";
  return cased_line(shot.from->x, shot.from->y, shot.to->x, shot.to->y, "reach") + circle(*shot.to, 3.5, "nearest");
}

std::string close_up_frame(const Shot& shot) {
  const double width = shot.close_up * shot.camera.width, height = shot.close_up * shot.camera.height;
  if (height < 28 || height > 0.9 * shot.camera.height) return "";  // would overlap the cross hairs or the rim
  const std::string place = "x=\"" + number(shot.from->x - width / 2) + "\" y=\"" + number(shot.from->y - height / 2) +
                            "\" width=\"" + number(width) + "\" height=\"" + number(height) + "\"/>";
  return "<rect class=\"frame-casing\" " + place + "<rect class=\"frame\" " + place;
}

std::string axes(const Camera& camera) {
  constexpr double kLength = 26;
  const double x = 44, y = camera.height - 44.0;
  std::string out;
  for (int k = 0; k < 3; ++k) {
    const double dx = kLength * camera.view.right[k], dy = -kLength * camera.view.up[k];
    if (std::hypot(dx, dy) < 4) continue;  // parallel to the view
    const double beyond = 1 + 9 / std::hypot(dx, dy);
    out += cased_line(x, y, x + dx, y + dy, "axis-line") +
           text_at(x + beyond * dx, y + beyond * dy + 4, "axis-name", std::string(1, static_cast<char>('x' + k)));
  }
  return out;
}

std::string scale_bar(const Camera& camera, const std::string& units) {
  const double length = svg::round_length(0.25 * camera.width * camera.pixel_size());
  if (!(length > 0)) return "";
  const double right = camera.width - 16.0, left = right - length / camera.pixel_size(), y = camera.height - 16.0;
  return cased_line(left, y, right, y, "scale-line") +
         text_at(0.5 * (left + right), y - 8, "scale-name", to_digits(length, 9) + (units.empty() ? "" : " " + units));
}

}  // namespace

std::string overlay(const Shot& shot, const std::string& units) {
  std::string out = "<svg viewBox=\"0 0 " + std::to_string(shot.camera.width) + " " +
                    std::to_string(shot.camera.height) + "\" aria-hidden=\"true\">";
  out += axes(shot.camera) + scale_bar(shot.camera, units);
  if (shot.from && inside(*shot.from, shot.camera)) {
    out += close_up_frame(shot) + reach_line(shot) + witness_mark(*shot.from, shot.hidden);
  }
  return out + "</svg>";
}

}  // namespace meshgauge::check
