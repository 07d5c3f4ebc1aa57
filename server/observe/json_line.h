// Writes one line of JSON from front to back. It takes a quarter of the time of an nlohmann document, and the log has a
// line for every request.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace meshgauge::server {

class JsonLine {
 public:
  JsonLine() : text_("{") {}

  // Precondition of all: `name` needs no escapes. A text value may be any bytes: control characters are escaped, bytes
  // that are not UTF-8 are replaced.
  JsonLine& add(std::string_view name, std::string_view value);
  JsonLine& add(std::string_view name, std::integral auto value) { return add_plain(name, std::to_string(value)); }
  JsonLine& add_bool(std::string_view name, bool value) { return add_plain(name, value ? "true" : "false"); }
  JsonLine& add_null(std::string_view name) { return add_plain(name, "null"); }
  JsonLine& add_ms(std::string_view name, double ms);  // with three decimals; null if not finite

  JsonLine& open(std::string_view name);  // begins an object that close() ends
  JsonLine& close();

  std::string finish() &&;  // the line, newline included

 private:
  JsonLine& add_plain(std::string_view name, std::string_view value);
  void begin(std::string_view name);

  std::string text_;
};

}  // namespace meshgauge::server
