// Messages to a session of the Model Context Protocol, one on a line; the tools run, on small files and for a moment.
// Asserted: each request and each refused message gets one answer, under its id; what is sent is one line of JSON, an
// answer or a notification of progress; the id that is found in a message which is not kept is that of the message.
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/base/text.h"
#include "cli/mcp/session.h"
#include "tests/folder.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

constexpr std::chrono::milliseconds kTimeOfCall{20};
constexpr std::size_t kMostTalkLines = 4;

mcp::Context talk_context() {
  static const api::test::Folder folder;
  static const auto confines = [] {
    folder.write("a.off", api::test::small_mesh(2));
    folder.write("b.off", api::test::small_mesh());
    folder.write("gates.yaml", "version: 1\ngates: [{name: x, candidate: a.off, baseline: b.off, max_distance: 5}]\n");
    api::Confines small{api::Roots::open({folder.path().string()}).value(), {10'000, 10'000, 1 << 20}, 1 << 20};
    return std::make_shared<const api::Confines>(std::move(small));
  }();
  return {confines, 1, {kTimeOfCall, kTimeOfCall}};
}

void require_tool_result(const nlohmann::json& result, std::string_view line) {
  require(!result.at("content").empty() && !result.at("content")[0].at("text").empty(), "a call says something", line);
  const bool has_found = result.contains("structuredContent") && result["structuredContent"].is_object();
  require(has_found != result.at("isError").get<bool>(), "a call finds something, or says that it fails", line);
}

// Returns the id of an answer as JSON; empty: the line is a notification.
std::string id_of_answer(std::string_view line) {
  require(line.find('\n') == std::string_view::npos, "an answer is one line", line);
  const auto message = nlohmann::json::parse(line, nullptr, false);
  require(message.is_object() && message.value("jsonrpc", "") == "2.0", "an answer is a message", line);
  if (message.contains("method")) {
    require(message["method"] == "notifications/progress" && !message.contains("id"), "progress is told", line);
    return "";
  }
  const bool has_one = message.contains("result") != message.contains("error");
  require(message.contains("id") && has_one, "an answer has its id, and a result or an error", line);
  if (message.contains("error")) {
    const bool is_whole = message["error"].at("code").is_number_integer() && !message["error"].at("message").empty();
    require(is_whole, "an error says why", line);
  } else if (message["result"].contains("content")) {
    require_tool_result(message["result"], line);
  }
  return message["id"].dump();
}

// The id under which a message is answered; empty: it is not.
std::string id_to_answer(std::string_view line) {
  const mcp::Received received = mcp::read_message(line);
  if (const auto* refusal = std::get_if<mcp::Refusal>(&received)) return refusal->id;
  const auto* request = std::get_if<mcp::Request>(&received);
  if (!request) return "";
  mcp::IdScanner scanner;
  scanner.take(line);
  const std::string found = scanner.id();
  require(found == "null" || found == request->id, "an id that is found in passing is the message's", line);
  return request->id;
}

void talk(std::string_view text) {
  std::vector<std::string> answered, asked;
  mcp::Session session(talk_context(), 0, [&](const std::string& line, mcp::Session::Line) {
    if (std::string id = id_of_answer(line); !id.empty()) answered.push_back(std::move(id));
  });
  for (std::size_t i = 0; i < kMostTalkLines && !text.empty(); ++i) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    if (api::trimmed(line).empty()) continue;
    if (std::string id = id_to_answer(line); !id.empty()) asked.push_back(std::move(id));
    session.receive(line);
    require(answered == asked, "each message is answered once, under its id", line);
  }
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(mcp) {
  meshgauge::fuzz::talk(meshgauge::fuzz::text_of(data, size));
  return 0;
}
