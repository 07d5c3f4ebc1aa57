#include "check/html/markup.h"

#include <openssl/evp.h>
#include <openssl/sha.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>

#include "api/base/utf8.h"

namespace meshgauge::check {
namespace {

constexpr std::string_view kReplacement = "\xEF\xBF\xBD";

bool turns_direction(std::uint32_t code) {
  return code == 0x061C || code == 0x200E || code == 0x200F || (code >= 0x202A && code <= 0x202E) ||
         (code >= 0x2066 && code <= 0x2069);
}

bool forbidden(std::uint32_t code) {
  if (code < 0x20) return code != '\t' && code != '\n';
  if (code >= 0x7F && code < 0xA0) return true;
  return (code >= 0xFDD0 && code <= 0xFDEF) || (code & 0xFFFE) == 0xFFFE || turns_direction(code);
}

std::string_view reference(char c) {
  switch (c) {
    case '&':
      return "&amp;";
    case '<':
      return "&lt;";
    case '>':
      return "&gt;";
    case '"':
      return "&quot;";
    case '\'':
      return "&#39;";
    default:
      return "";
  }
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  out.reserve(text.size() + text.size() / 8);
  for (std::size_t at = 0; at < text.size();) {
    const Character next = decode(text.substr(at));
    const std::string_view as_reference = reference(text[at]);
    if (next.bytes == 0 || forbidden(next.code)) {
      out += kReplacement;
    } else {
      out += as_reference.empty() ? text.substr(at, next.bytes) : as_reference;
    }
    at += next.bytes ? next.bytes : 1;
  }
  return out;
}

std::string base64(std::span<const std::byte> bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // EVP_EncodeBlock appends a zero
  const int length =
      EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                      reinterpret_cast<const unsigned char*>(bytes.data()), static_cast<int>(bytes.size()));
  text.resize(static_cast<std::size_t>(length));
  return text;
}

std::string sha256_base64(std::string_view text) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(text.data()), text.size(), digest.data());
  return base64(std::as_bytes(std::span(digest)));
}

}  // namespace meshgauge::check

namespace meshgauge::check::svg {
namespace {

// Text anchor for a label at `share` of the width that keeps it inside.
std::string_view anchor(double share) { return share < 0.12 ? "start" : share > 0.88 ? "end" : "middle"; }

}  // namespace

std::string percent(double share) { return number(100 * std::clamp(share, 0.0, 1.0)) + "%"; }

std::string number(double x) {
  if (!std::isfinite(x)) return "0";
  char text[400];  // longer than any double
  std::snprintf(text, sizeof text, "%.2f", x);
  return text;
}

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
