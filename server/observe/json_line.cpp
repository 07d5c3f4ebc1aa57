#include "server/observe/json_line.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include <nlohmann/json.hpp>

namespace meshgauge::server {
namespace {

bool is_plain(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c >= ' ' && c <= '~' && c != '"' && c != '\\'; });
}

}  // namespace

void JsonLine::begin(std::string_view name) {
  if (text_.back() != '{') text_ += ',';
  text_.append("\"").append(name).append("\":");
}

JsonLine& JsonLine::add_plain(std::string_view name, std::string_view value) {
  begin(name);
  text_ += value;
  return *this;
}

JsonLine& JsonLine::add(std::string_view name, std::string_view value) {
  begin(name);
  if (is_plain(value)) {
    text_.append("\"").append(value).append("\"");
  } else {
    text_ += nlohmann::json(value).dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
  }
  return *this;
}

JsonLine& JsonLine::add_ms(std::string_view name, double ms) {
  if (!std::isfinite(ms)) return add_null(name);
  std::array<char, 400> text{};  // the largest double has 309 digits
  const int n = std::snprintf(text.data(), text.size(), "%.3f", ms);
  return add_plain(name, {text.data(), static_cast<std::size_t>(n)});
}

JsonLine& JsonLine::open(std::string_view name) {
  begin(name);
  text_ += '{';
  return *this;
}

JsonLine& JsonLine::close() {
  text_ += '}';
  return *this;
}

std::string JsonLine::finish() && {
  text_ += "}\n";
  return std::move(text_);
}

}  // namespace meshgauge::server
