// One line of JSON, written from front to back: a document of nlohmann's takes four times as long to make, and the log
// has a line for every request.
#pragma once

#include <concepts>
#include <string>
#include <string_view>

namespace meshgauge::server {

class JsonLine {
 public:
  JsonLine() : text_("{") {}

  // Names are ours and need no escapes. A value may be any bytes: control characters are escaped, what is not UTF-8 is
  // replaced.
  JsonLine& add(std::string_view name, std::string_view value);
  JsonLine& add(std::string_view name, std::integral auto value) { return add_plain(name, std::to_string(value)); }
  JsonLine& add_bool(std::string_view name, bool value) { return add_plain(name, value ? "true" : "false"); }
  JsonLine& add_null(std::string_view name) { return add_plain(name, "null"); }
  JsonLine& add_ms(std::string_view name, double ms);  // in steps of a microsecond

  JsonLine& open(std::string_view name);  // an object, up to close()
  JsonLine& close();

  std::string finish() &&;  // with a newline

 private:
  JsonLine& add_plain(std::string_view name, std::string_view value);
  void begin(std::string_view name);

  std::string text_;
};

}  // namespace meshgauge::server
