#include "api/base/json_filter.h"

#include <algorithm>

#include "api/base/refused.h"
#include "api/base/utf8.h"

namespace meshgauge::api {

bool JsonFilter::value() {
  if (!levels_.empty()) ++levels_.back().values;
  if (++values_ <= most_values_) return true;
  where = pointer();
  defect = "more than " + std::to_string(most_values_) + " values";
  return false;
}

bool JsonFilter::open(bool array) {
  if (!value()) return false;
  levels_.push_back({array, 0, {}, {}});
  if (levels_.size() <= kMaxDepth) return true;
  defect = "nested deeper than " + std::to_string(kMaxDepth) + " levels";
  return false;
}

bool JsonFilter::close() {
  levels_.pop_back();
  return true;
}

bool JsonFilter::key(string_t& key) {
  Level& level = levels_.back();
  level.key = key.substr(0, 64);
  if (level.keys.insert(key).second) return true;
  where = pointer();
  defect = "the key " + shown_text(key) + " occurs twice in one object";
  return false;
}

bool JsonFilter::parse_error(std::size_t position, const std::string&, const nlohmann::detail::exception& error) {
  const std::string_view text = error.what();
  const std::size_t tag = text.find("] ");  // "[json.exception.parse_error.101] parse error at ..."
  where = "byte " + std::to_string(position);
  defect = "not JSON: " + std::string(tag == std::string_view::npos ? text : text.substr(tag + 2));
  return false;
}

std::string JsonFilter::pointer() const {
  std::string pointer;
  for (const Level& level : levels_) pointer += "/" + (level.array ? std::to_string(level.values - 1) : level.key);
  return pointer;
}

Result<nlohmann::json> parse_document(std::string_view json, const std::string& part, std::size_t max_bytes) {
  const std::string quoted = "'" + part + "'";
  if (json.size() > max_bytes) {
    return Error{ErrorCode::too_large, quoted + " is larger than " + std::to_string(max_bytes) + " bytes", part, ""};
  }
  if (const std::size_t nul = json.find('\0');
      nul != std::string_view::npos) {  // the parser would take NUL as the end of the text
    return refused(quoted + " is refused: not JSON: a NUL byte", part, "byte " + std::to_string(nul));
  }
  JsonFilter filter;
  if (nlohmann::json::sax_parse(json, &filter)) return nlohmann::json::parse(json);
  return refused(quoted + " is refused: " + filter.defect, part, filter.where);
}

std::string shown_text(std::string_view text) {
  std::size_t end = std::min<std::size_t>(text.size(), 64);
  while (end < text.size() && end > 0 && is_within_character(text[end])) --end;
  std::string out = "'";
  for (const char c : text.substr(0, end)) out += is_control(c) ? '?' : c;
  return out + (text.size() > end ? "...'" : "'");
}

std::string shown(const nlohmann::json& value) {
  if (value.is_structured()) return value.is_array() ? "an array" : "an object";
  if (value.is_string()) return shown_text(value.get_ref<const std::string&>());
  return value.dump();
}

}  // namespace meshgauge::api
