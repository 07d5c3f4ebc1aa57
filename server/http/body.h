// Reads the body of a request piece by piece: bounded in size, under one absolute deadline, never in memory as a whole.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "api/problem.h"
#include "server/http/connection.h"
#include "server/http/head.h"

namespace meshgauge::server {

// Returns the problem for a head or body (`what` names which) whose reading ended with `io` before it was complete.
// `time`: the time limit, for the message. Precondition: io is not Io::ok.
api::Problem not_arrived(Io io, const std::string& what, std::chrono::milliseconds time);

class Body {
 public:
  using Refusal = std::optional<api::Problem>;
  using Receive = std::function<Refusal(std::string_view piece)>;

  // Borrows connection and head. `time` starts with read().
  Body(Connection& connection, const Head& head, std::uint64_t max_bytes, std::chrono::milliseconds time);

  // Passes the body to `receive` piece by piece. Returns nullopt at its end; else the first refusal of `receive`, or
  // the problem of a body that is malformed, too large or late. Sends 100 Continue to a client that expects it. Blocks
  // for `time` at most. Call once.
  Refusal read(const Receive& receive);

  // Discards the rest of the body if all of it is in the connection's buffer, so that the connection can serve the next
  // request after a refusal. Does not block.
  void discard_arrived();

  bool consumed() const { return consumed_; }     // the whole body was taken off the connection
  std::uint64_t bytes() const { return bytes_; }  // received so far

 private:
  Refusal read_sized(std::uint64_t left, const Receive& receive);
  Refusal read_chunked(const Receive& receive);
  Refusal read_chunk_size(std::uint64_t& size);
  Refusal read_line(std::string_view& line);
  Refusal expect_crlf();
  Refusal read_trailers();
  Refusal more();

  Connection& connection_;
  const Head& head_;
  std::uint64_t max_bytes_;
  std::chrono::milliseconds time_;
  Clock::time_point deadline_;
  std::uint64_t bytes_ = 0;
  bool consumed_;
};

}  // namespace meshgauge::server
