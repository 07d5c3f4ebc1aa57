#include "check/html/diagrams.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>
#include <vector>

#include "api/base/figures.h"
#include "check/html/markup.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using svg::box;
using svg::cased_line;
using svg::label;
using svg::line;
using svg::number;
using svg::percent;

std::string hex(const api::Rgb& colour) {
  char text[8];
  std::snprintf(text, sizeof text, "#%02x%02x%02x", colour.red, colour.green, colour.blue);
  return text;
}

std::string drawing(std::string_view css_class, int height, const std::string& described, const std::string& content) {
  return "<svg class=\"" + std::string(css_class) + "\" width=\"100%\" height=\"" + std::to_string(height) +
         "\" role=\"img\" aria-label=\"" + escaped(described) + "\">" + content + "</svg>";
}

std::string axis_ticks(const Axis& axis, int y) {
  std::string out = box("axis", 0, 1, y, 1);
  for (const AxisTick& tick : ticks(axis)) {
    out += line("tick", axis.at(tick.value), y, y + 5);
    out += label("tick-name", axis.at(tick.value), y + 18, tick.label);
  }
  return out;
}

std::string sign(Verdict verdict) {
  switch (verdict) {
    case Verdict::pass:
      return "<path d=\"M4.5 8.5l2.5 2.5 4.5-5.5\"/>";
    case Verdict::fail:
      return "<path d=\"M5 5l6 6M11 5l-6 6\"/>";
    case Verdict::undecided:
      return "<path d=\"M5.8 6.2a2.2 2.2 0 1 1 3.2 2c-.8.4-1 .8-1 1.5M8 11.8v.2\"/>";
    case Verdict::error:
      return "<path d=\"M8 4v5M8 11.8v.2\"/>";
  }
  return "";
}

std::string ramp() {
  constexpr int kStops = 24;
  std::string out = "<linearGradient id=\"ramp\">";
  for (int i = 0; i <= kStops; ++i) {
    const double share = static_cast<double>(i) / kStops;
    out += "<stop offset=\"" + percent(share) + "\" stop-color=\"" + hex(api::map_colour(share)) + "\"/>";
  }
  return out + "</linearGradient>";
}

// An unknown upper bound extends to the end.
std::string interval_bar(double from, double to, Verdict verdict, int y, int height) {
  const std::string kind(to_string(verdict));
  return box("bar " + kind, from, to, y, height) + line("cap " + kind, from, y - 3, y + height + 3) +
         line("cap " + kind, to, y - 3, y + height + 3);
}

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

std::string definitions() {
  std::string out = "<svg class=\"definitions\" width=\"0\" height=\"0\" aria-hidden=\"true\"><defs>" + ramp();
  out +=
      "<pattern id=\"hatch\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" patternTransform=\"rotate(45)\">"
      "<rect class=\"hatch\" width=\"2\" height=\"7\"/></pattern>";
  out +=
      "<pattern id=\"hatch-above\" width=\"7\" height=\"7\" patternUnits=\"userSpaceOnUse\" "
      "patternTransform=\"rotate(45)\"><rect width=\"7\" height=\"7\" fill=\"" +
      hex(api::kAboveLimit) + "\"/><rect width=\"2\" height=\"7\" fill=\"#ffc4b2\"/></pattern>";
  return out + "</defs></svg>";
}

std::string icon(Verdict verdict) {
  return "<svg class=\"icon\" viewBox=\"0 0 16 16\" width=\"16\" height=\"16\" aria-hidden=\"true\">"
         "<circle cx=\"8\" cy=\"8\" r=\"8\"/>" +
         sign(verdict) + "</svg>";
}

std::string interval_drawing(const Criterion& found, const std::string& units) {
  const Criterion criterion = found.beyond ? api::in_percent(found) : found;
  // An unknown upper bound has no place on the axis; it extends to the end.
  const LimitEnds ends = criterion.ends();
  std::vector<double> values{criterion.lower, ends.pass, ends.fail};
  if (std::isfinite(criterion.upper)) values.push_back(criterion.upper);
  const Axis axis = axis_for(values);
  const IntervalText text = figures_of(found);
  const double limit = axis.at(criterion.limit), from = axis.at(criterion.lower), to = axis.at(criterion.upper);

  const std::string unit = criterion.beyond ? "%" : units;
  const std::string what =
      criterion.beyond ? "The share of the area farther than " + api::with_unit(to_digits(*criterion.beyond, 6), units)
                       : "The " + criterion.name;
  std::string out = box("ground pass", 0, axis.at(ends.pass), 22, 36) +
                    box("ground fail", axis.at(ends.fail), 1, 22, 36) +
                    box("ground-hatch", axis.at(ends.fail), 1, 22, 36);
  out += "<text class=\"ground-name\" x=\"0\" dx=\"8\" y=\"36\">pass</text>";
  out += "<text class=\"ground-name\" x=\"100%\" dx=\"-8\" y=\"36\" text-anchor=\"end\">fail</text>";
  out += interval_bar(from, to, verdict_of(criterion.verdict), 34, 12);
  out += line("limit", limit, 16, 64) + label("limit-name", limit, 12, "limit " + api::with_unit(text.limit, unit));
  out += label("value", 0.5 * (from + to), 76, api::with_unit(text.both(), unit));
  out += axis_ticks(axis, 84);
  const std::string svg = drawing(
      "interval", 106,
      what + " is between " + text.lower + " and " + text.upper + (criterion.beyond ? " %" : "") + "; the limit is " +
          text.limit + (criterion.beyond ? " %" : "") + (axis.logarithmic ? ". Logarithmic axis." : ". Linear axis."),
      out);
  if (!criterion.beyond && criterion.region.empty() && criterion.side.empty()) return svg;
  return "<figure><figcaption>" + escaped(what) + "</figcaption>" + svg + "</figure>";
}

std::string interval_line(const Criterion& criterion) {
  // x/(1+x) of the share of the limit: 0 at the left, the limit in the middle, infinity at the right.
  const auto place = [&](double x) {
    const double share = criterion.limit > 0 ? x / criterion.limit : x > 0 ? INFINITY : 0;
    return std::isfinite(share) ? share / (1 + share) : 1;
  };
  const LimitEnds ends = criterion.ends();
  const bool apart = ends.are_apart();
  const double pass = apart ? place(ends.pass) : 0.5, fail = apart ? place(ends.fail) : 0.5;
  std::string out =
      box("ground pass", 0, pass, 3, 14) + box("ground fail", fail, 1, 3, 14) + box("ground-hatch", fail, 1, 3, 14);
  out += interval_bar(place(criterion.lower), place(criterion.upper), verdict_of(criterion.verdict), 7, 6) +
         line("limit", 0.5, 0, 20);
  return "<svg class=\"interval-line\" width=\"100%\" height=\"20\" aria-hidden=\"true\">" + out + "</svg>";
}

std::string history_drawing(const Chart& chart) {
  const std::vector<PastRun>& runs = chart.runs;
  constexpr int kTop = 6, kBottom = 86;
  if (runs.size() < 2) return "";
  double high = 0;
  for (const PastRun& run : runs)
    high = std::max({high, 1.25 * run.ends().fail, run.upper.value_or(run.lower.value_or(0))});
  const auto y = [&](double x) {
    return high > 0 ? kBottom - static_cast<int>(std::lround(std::min(x / high, 1.0) * (kBottom - kTop))) : kBottom;
  };
  const double width = 1 / static_cast<double>(std::max<std::size_t>(runs.size(), 12));
  std::string out = box("axis", 0, 1, kBottom, 1);
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const PastRun& run = runs[i];
    const double from = static_cast<double>(i) * width;
    if (const LimitEnds ends = run.ends(); run.limit && ends.are_apart()) {
      const int top = y(ends.fail);
      out += box("uncertain-step", from, from + width, top, y(ends.pass) - top);
    }
    if (run.limit) out += box("limit-step", from, from + width, y(*run.limit), 2);
    if (!run.lower) continue;
    const int top = run.upper ? y(*run.upper) : kTop, height = std::max(y(*run.lower) - top, 4);
    out += box("bar " + std::string(to_string(run.verdict)), from + 0.2 * width, from + 0.8 * width,
               std::min(top, kBottom - height), height);
  }
  const auto& last = runs.back();
  const std::string limit =
      last.limit ? "; the limit is " + api::with_unit(to_digits(*last.limit, 6), chart.unit) + margin_of(chart) : "";
  return "<figure><figcaption>Last " + std::to_string(runs.size()) +
         " runs, the newest on the right: " + escaped(chart.what) + "</figcaption>" +
         drawing("history", kBottom + 2,
                 "The intervals of the last " + std::to_string(runs.size()) + " runs" + limit + ".", out) +
         "</figure>";
}

std::string histogram_drawing(const Histogram& histogram, double limit, const std::string& units) {
  constexpr int kTop = 18, kBottom = 138;
  const auto bins = static_cast<double>(histogram.shares.size());
  double least = 1;
  for (const double share : histogram.shares) least = share > 0 ? std::min(least, share) : least;
  // Logarithmic shares, so that a thousandth of the surface is visible.
  const double decades = std::max(1.0, std::ceil(-std::log10(least) + 0.05));
  const auto height = [&](double share) {
    return share > 0 ? std::max(2.0, (kBottom - kTop) * (1 + std::log10(share) / decades)) : 0;
  };

  std::string out;
  for (int i = 0; i < static_cast<int>(decades); ++i) {
    const int y = kBottom - static_cast<int>(height(std::pow(10, -i)));
    out += box("grid", 0, 1, y, 1) + label("grid-name", 1, y + 12, to_digits(100 * std::pow(10, -i), 3) + " %");
  }
  for (std::size_t i = 0; i < histogram.shares.size(); ++i) {
    if (!(histogram.shares[i] > 0)) continue;
    const double begins = static_cast<double>(i) / bins, middle = begins + 0.5 / bins;
    const bool above = histogram.axis.value(middle) > limit;
    const std::string fill = above ? "url(#hatch-above)" : hex(api::map_colour(histogram.axis.value(begins) / limit));
    const double tall = height(histogram.shares[i]);
    out += "<rect class=\"bin\" fill=\"" + fill + "\" x=\"" + percent(begins) + "\" width=\"" + percent(0.92 / bins) +
           "\" y=\"" + number(kBottom - tall) + "\" height=\"" + number(tall) + "\"/>";
  }
  const double at = histogram.axis.at(limit);
  out += line("limit", at, 14, kBottom + 4) + label("limit-name", at, 11, "limit");
  out += axis_ticks(histogram.axis, kBottom);
  const double above = 100 * histogram.above_limit;
  return drawing("histogram", kBottom + 24,
                 std::string("Histogram of the distances ") +
                     (histogram.of_cloud ? "of the points" : "over the surface") +
                     (units.empty() ? "" : ", in " + units) + ": " + to_digits(above, 3) + " % of the " +
                     (histogram.of_cloud ? "points are" : "area is") + " above the limit.",
                 out);
}

std::string colour_bar(const api::ColourScale& scale, const std::string& units) {
  constexpr double kLimit = 0.8, kAbove = 0.84;
  std::string out =
      "<rect fill=\"url(#ramp)\" class=\"ramp\" x=\"0\" y=\"2\" width=\"" + percent(kLimit) + "\" height=\"14\"/>";
  out += "<rect fill=\"url(#hatch-above)\" class=\"ramp\" x=\"" + percent(kAbove) + "\" y=\"2\" width=\"" +
         percent(1 - kAbove) + "\" height=\"14\"/>";
  const auto marks = api::legend_ticks(scale);
  for (const api::Tick& tick : marks) {
    const bool last = &tick == &marks.back() && scale.top > 0;
    const double at = scale.top > 0 ? kLimit * tick.value / scale.top : 0;
    out += line(last ? "limit" : "tick", at, last ? 0 : 16, last ? 22 : 20);
    if (!last) out += label("tick-name", at, 33, to_digits(tick.value, 9));
  }
  out += "<text class=\"tick-name strong\" x=\"" + percent(kLimit) + "\" y=\"33\" text-anchor=\"middle\">limit" +
         (scale.top > 0 ? " " + to_digits(scale.top, 4) : "") + "</text>";
  out += label("tick-name", 1, 33, "above");
  return drawing("colour-bar", 38,
                 "Colours: from dark violet at distance 0 to light yellow at the limit; red and hatched above it" +
                     (units.empty() ? "." : ", in " + units + "."),
                 out);
}

std::string overlay(const Shot& shot, const std::string& units) {
  std::string out = "<svg viewBox=\"0 0 " + std::to_string(shot.camera.width) + " " +
                    std::to_string(shot.camera.height) + "\" aria-hidden=\"true\">";
  out += axes(shot.camera) + scale_bar(shot.camera, units);
  if (shot.from && inside(*shot.from, shot.camera)) {
    out += close_up_frame(shot) + reach_line(shot) + witness_mark(*shot.from, shot.hidden);
  }
  return out + "</svg>";
}

std::string share_bar(double share) {
  return "<svg class=\"share\" width=\"100%\" height=\"10\" aria-hidden=\"true\">" + box("share-bar", 0, share, 1, 8) +
         "</svg>";
}

}  // namespace meshgauge::check
