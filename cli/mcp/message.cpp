#include "cli/mcp/message.h"

#include <optional>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/text.h"

namespace meshgauge::mcp {
namespace {

constexpr std::size_t kMostValues = 100'000;   // of a message: each takes some ten times its bytes
constexpr std::size_t kMostDefectBytes = 300;  // of the parser's words, which repeat what was sent

std::string dumped(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

// Returns why the line is no message; nullopt: `message` is what it says.
std::optional<Refusal> parse(std::string_view line, nlohmann::json& message) {
  if (line.find('\0') != std::string_view::npos) return Refusal{kNotJson, "not JSON: a NUL byte"};
  api::JsonFilter filter(kMostValues);
  if (nlohmann::json::sax_parse(line, &filter)) {
    message = nlohmann::json::parse(line);
    return std::nullopt;
  }
  const std::string defect = api::printable(filter.defect, kMostDefectBytes);
  if (filter.defect.starts_with("not JSON")) return Refusal{kNotJson, defect};
  return Refusal{kInvalidMessage, defect, id_in(line)};
}

Received read_object(nlohmann::json& message) {
  const auto id = message.find("id"), method = message.find("method"), params = message.find("params");
  const bool is_answer = method == message.end() && (message.contains("result") || message.contains("error"));
  if (is_answer) return std::monostate{};  // whatever its id: an error about a message that was not read has null
  const bool has_id = id != message.end();
  const std::string own_id = has_id ? text_of_id(*id) : "";
  if (has_id && own_id.empty())
    return Refusal{kInvalidMessage, "id must be a whole number or a text of at most " + std::to_string(kMostIdBytes) +
                                        " bytes, not " + api::shown(*id)};
  const std::string known_id = has_id ? own_id : "null";
  const auto version = message.find("jsonrpc");
  if (version == message.end() || *version != "2.0")
    return Refusal{kInvalidMessage, "jsonrpc must be \"2.0\"", known_id};
  if (method == message.end()) return Refusal{kInvalidMessage, "the message has no method", known_id};
  if (!method->is_string())
    return Refusal{kInvalidMessage, "method must be a text, not " + api::shown(*method), known_id};
  Request request{own_id, method->get<std::string>()};
  if (params == message.end()) return request;
  if (params->is_object()) {
    request.params = std::move(*params);
    return request;
  }
  if (!has_id) return std::monostate{};
  return Refusal{kInvalidParams, "params must be an object, not " + api::shown(*params), known_id};
}

}  // namespace

Received read_message(std::string_view line) {
  nlohmann::json message;
  if (auto refusal = parse(line, message)) return *std::move(refusal);
  if (message.is_array())
    return Refusal{kInvalidMessage, "batches are not part of this protocol: send each message on a line of its own"};
  if (!message.is_object()) return Refusal{kInvalidMessage, "a message must be an object, not " + api::shown(message)};
  return read_object(message);
}

std::string text_of_id(const nlohmann::json& id) {
  if (id.is_number_integer()) return id.dump();
  if (!id.is_string() || id.get_ref<const std::string&>().size() > kMostIdBytes) return "";
  return id.dump();
}

std::string id_in(std::string_view line) {
  IdScanner scanner;
  scanner.take(line);
  return scanner.id();
}

std::string answer_line(const std::string& id, const Json& result) {
  return R"({"jsonrpc":"2.0","id":)" + id + R"(,"result":)" + dumped(result) + "}";
}

std::string refusal_line(const Refusal& refusal) {
  const Json error{{"code", refusal.code}, {"message", refusal.message}};
  return R"({"jsonrpc":"2.0","id":)" + refusal.id + R"(,"error":)" + dumped(error) + "}";
}

std::string notification_line(std::string_view method, const Json& params) {
  return dumped(Json{{"jsonrpc", "2.0"}, {"method", method}, {"params", params}});
}

void IdScanner::take(std::string_view piece) {
  for (const char c : piece) take(c);
}

void IdScanner::take(char c) {
  if (in_text_) {
    keep(c);
    if (is_escaped_) {
      is_escaped_ = false;
    } else if (c == '\\') {
      is_escaped_ = true;
    } else if (c == '"') {
      in_text_ = false;
    }
  } else if (c == '"') {
    in_text_ = true;
    keep(c);
  } else if (c == '{' || c == '[') {
    keep(c);  // no value that is an id
    ++depth_;
  } else if (c == '}' || c == ']' || c == ',') {
    end_member();
    if (c != ',') --depth_;
  } else if (c == ':' && depth_ == 1) {
    is_value_ = true;
  } else if (!api::is_space(c)) {
    keep(c);
  }
}

void IdScanner::keep(char c) {
  std::string& text = is_value_ ? value_ : key_;
  if (depth_ == 1 && text.size() <= kMostIdBytes + 2) text += c;  // 2: the quotes
}

void IdScanner::end_member() {
  if (depth_ != 1) return;
  if (key_ == "\"id\"") id_ = value_;
  key_.clear();
  value_.clear();
  is_value_ = false;
}

std::string IdScanner::id() const {
  const auto found = nlohmann::json::parse(id_, nullptr, false);
  const std::string text = found.is_discarded() ? "" : text_of_id(found);
  return text.empty() ? "null" : text;
}

}  // namespace meshgauge::mcp
