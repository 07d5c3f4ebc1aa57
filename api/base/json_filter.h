// Checks untrusted JSON before a tree is built: a tree of unbounded depth overflows the stack when it is copied or
// destroyed, and nlohmann::json silently keeps the last of duplicate keys.
#pragma once

#include <cstddef>
#include <limits>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "engine/result.h"

namespace meshgauge::api {

// Handler for one nlohmann::json::sax_parse(). When that returns false, `defect` says what is wrong and `where` has the
// place: a JSON pointer, or "byte N" for a syntax error.
class JsonFilter : public nlohmann::json_sax<nlohmann::json> {
 public:
  static constexpr std::size_t kMaxDepth = 16;

  // `most_values`: of the whole text. A tree has many bytes for each, however short it is.
  explicit JsonFilter(std::size_t most_values = std::numeric_limits<std::size_t>::max()) : most_values_(most_values) {}

  std::string defect;
  std::string where;

  bool null() override { return value(); }
  bool boolean(bool) override { return value(); }
  bool number_integer(number_integer_t) override { return value(); }
  bool number_unsigned(number_unsigned_t) override { return value(); }
  bool number_float(number_float_t, const string_t&) override { return value(); }
  bool string(string_t&) override { return value(); }
  bool binary(binary_t&) override { return value(); }
  bool start_object(std::size_t) override { return open(false); }
  bool start_array(std::size_t) override { return open(true); }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }
  bool key(string_t& key) override;
  bool parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) override;

 private:
  struct Level {
    bool array;
    std::size_t values = 0;  // array: number of values so far
    std::string key;         // object: the last key
    std::set<std::string> keys;
  };

  bool value();
  bool open(bool array);
  bool close();
  std::string pointer() const;

  const std::size_t most_values_;
  std::size_t values_ = 0;
  std::vector<Level> levels_;
};

// Parses a document that JsonFilter accepts. `part` names the document in errors; Error::where is a JSON pointer or
// "byte N". Errors: too_large above `max_bytes`, else invalid_request.
Result<nlohmann::json> parse_document(std::string_view json, const std::string& part, std::size_t max_bytes);

// Quotes untrusted text for a message: shortened, on one line.
std::string shown_text(std::string_view text);
std::string shown(const nlohmann::json& value);

}  // namespace meshgauge::api
