// A session of the Model Context Protocol with one client: takes messages in, answers them, and calls the tools.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "cli/mcp/calls.h"
#include "cli/mcp/message.h"
#include "cli/mcp/tool.h"

namespace meshgauge::mcp {

// All functions belong to one thread.
class Session {
 public:
  enum class Line { answer, progress };  // progress may be lost
  // Sends one line, without its end. Called on any thread, at several at the same time.
  using Send = std::function<void(std::string line, Line what)>;

  // `threads`: of calls at the same time; 0: receive() runs them.
  Session(Context context, unsigned threads, Send send);

  // Takes a message. A call of a tool is answered later; everything else at once.
  void receive(std::string_view line);
  // Refuses a message that was too long to be kept; `id`: its own as JSON, or "null".
  void refuse_long(const std::string& id);

  // As Calls::end().
  bool end(std::chrono::milliseconds patience) { return calls_.end(patience); }

 private:
  void take(Request request, std::size_t bytes);
  void notified(const Request& request);
  void call_tool(Request request, std::size_t bytes);
  std::string answer_of(const Tool& tool, Request& request, Control& control) const;
  ToolAnswer run(const Tool& tool, Request& request, Control& control) const;
  void refuse(int code, const std::string& message, const std::string& id) const;

  const Context context_;
  const Send send_;
  Calls calls_;  // last member: calls use all members above
};

}  // namespace meshgauge::mcp
