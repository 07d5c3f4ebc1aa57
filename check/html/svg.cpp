#include "check/html/svg.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "check/html/markup.h"

namespace meshgauge::check::svg {

std::string percent(double share) { return number(100 * std::clamp(share, 0.0, 1.0)) + "%"; }

std::string number(double x) {
  if (!std::isfinite(x)) return "0";
  char text[400];  // longer than any double
  std::snprintf(text, sizeof text, "%.2f", x);
  return text;
}

std::string_view anchor(double share) { return share < 0.12 ? "start" : share > 0.88 ? "end" : "middle"; }

std::string label(std::string_view css_class, double share, int y, const std::string& plain_text) {
  std::string out("<text class=\"");
  out.append(css_class).append("\" x=\"").append(percent(share)).append("\" y=\"").append(std::to_string(y));
  out.append("\" text-anchor=\"").append(anchor(share)).append("\">").append(escaped(plain_text)).append("</text>");
  return out;
}

std::string line(std::string_view css_class, double share, int y1, int y2) {
  const std::string x = percent(share);
  std::string out("<line class=\"");
  out.append(css_class).append("\" x1=\"").append(x).append("\" x2=\"").append(x);
  out.append("\" y1=\"").append(std::to_string(y1)).append("\" y2=\"").append(std::to_string(y2)).append("\"/>");
  return out;
}

std::string box(std::string_view css_class, double from, double to, int y, int height) {
  std::string out("<rect class=\"");
  out.append(css_class).append("\" x=\"").append(percent(from)).append("\" width=\"").append(percent(to - from));
  out.append("\" y=\"").append(std::to_string(y)).append("\" height=\"").append(std::to_string(height)).append("\"/>");
  return out;
}

std::string cased_line(double x1, double y1, double x2, double y2, std::string_view css_class) {
  const std::string ends =
      "x1=\"" + number(x1) + "\" y1=\"" + number(y1) + "\" x2=\"" + number(x2) + "\" y2=\"" + number(y2) + "\"/>";
  return "<line class=\"casing\" " + ends + "<line class=\"" + std::string(css_class) + "\" " + ends;
}

double round_length(double most) {
  if (!(most > 1e-290 && most < 1e290)) return 0;
  const double power = std::pow(10, std::floor(std::log10(most)));
  const double digits = most / power;
  return power * (digits >= 5 ? 5 : digits >= 2 ? 2 : 1);
}

}  // namespace meshgauge::check::svg
