// Messages of JSON-RPC 2.0 as the Model Context Protocol has them: one on a line, no batches.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include <nlohmann/json.hpp>

namespace meshgauge::mcp {

using Json = nlohmann::ordered_json;  // what is written

// Codes of errors.
inline constexpr int kNotJson = -32700, kInvalidMessage = -32600, kUnknownMethod = -32601, kInvalidParams = -32602,
                     kBusy = -32000;

inline constexpr std::size_t kMostIdBytes = 256;

struct Request {
  std::string id;  // as JSON; empty: a notification, which gets no answer
  std::string method;
  nlohmann::json params = nlohmann::json::object();
};

struct Refusal {
  int code = kInvalidMessage;
  std::string message;
  std::string id = "null";  // of the refused message, as JSON; null: not known
};

// monostate: nothing to do, such as for the client's answer to a request.
using Received = std::variant<std::monostate, Request, Refusal>;

// Reads one message. Never throws for what a client can send, but std::bad_alloc.
Received read_message(std::string_view line);

// Returns the id as JSON; empty: it is none, that is, no whole number and no text of at most kMostIdBytes.
std::string text_of_id(const nlohmann::json& id);
// Returns the id of a message that is not parsed, as JSON; "null": none was found.
std::string id_in(std::string_view line);

// Lines that are sent, without their ends. Bytes that are not UTF-8 become U+FFFD.
std::string answer_line(const std::string& id, const Json& result);
std::string refusal_line(const Refusal& refusal);
std::string notification_line(std::string_view method, const Json& params);

// Finds the id of a message that is not kept, while it passes by in pieces.
class IdScanner {
 public:
  void take(std::string_view piece);
  std::string id() const;  // as JSON; "null": none was found

 private:
  void take(char c);
  void keep(char c);
  void end_member();

  std::int64_t depth_ = 0;
  bool in_text_ = false;
  bool is_escaped_ = false;
  bool is_value_ = false;         // the member's value has begun
  std::string key_, value_, id_;  // of the message's own members, as JSON, cut behind kMostIdBytes
};

}  // namespace meshgauge::mcp
