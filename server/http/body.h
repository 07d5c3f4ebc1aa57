// The body of a request as it streams in: bounded, under one absolute deadline, never in memory as a whole.
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

// What to answer when the head or the body (`what`) has not arrived within `time`, or was not waited for any longer.
// Precondition: io is not ok.
api::Problem not_arrived(Io io, const std::string& what, std::chrono::milliseconds time);

class Body {
 public:
  using Refusal = std::optional<api::Problem>;
  using Receive = std::function<Refusal(std::string_view piece)>;

  // Borrows both. The deadline starts with read().
  Body(Connection& connection, const Head& head, std::uint64_t max_bytes, std::chrono::milliseconds time);

  // Hands the whole body to `receive`, piece by piece, until its end or the first refusal. Invites a client that
  // sent Expect: 100-continue; one whose body is never read is never invited. Once.
  Refusal read(const Receive& receive);

  // Takes the rest, unless it still has to be waited for: after a refusal the connection can then go on.
  void discard_arrived();

  bool consumed() const { return consumed_; }     // nothing of it is left on the connection
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
