// Receives the body of a request piece by piece as it arrives: bounded in size, never in memory as a whole. Nothing
// here blocks.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "api/base/problem.h"
#include "server/http/connection.h"
#include "server/http/head.h"

namespace meshgauge::server {

class Body {
 public:
  using Step = Transport::Step;
  using Refusal = std::optional<api::Problem>;
  using Receive = std::function<Refusal(std::string_view piece)>;
  using End = std::function<void(const Refusal& refusal)>;

  // Borrows connection and head.
  Body(Connection& connection, const Head& head, std::uint64_t max_bytes);

  // Begins to receive: `receive` gets the pieces; then `end` is called once, with the first refusal of `receive`, or
  // with the problem of a body that is malformed, too large or did not arrive. Both are called on the request's thread,
  // after the handler has returned. Call once.
  void read(Receive receive, End end);
  bool reading() const { return end_ != nullptr; }

  // Takes what has arrived. done: `end` was called; else what to wait for. Sends 100 Continue to a client that expects
  // it. Precondition: reading().
  Step go_on();
  void stop(const Refusal& refusal);  // ends the reading
  void abandon();                     // ends it without calling `end`

  // Number of bytes of the body that are not taken off the connection yet. Max: it cannot be known, as for chunks, or
  // when the client may not send them.
  std::uint64_t left() const;

  bool consumed() const { return consumed_; }     // the whole body was taken off the connection
  std::uint64_t bytes() const { return bytes_; }  // received so far

 private:
  enum class State { sized, chunk_size, chunk, chunk_end, trailers };

  bool invite();
  Refusal take(bool& stuck);
  Refusal take_bytes(bool& stuck);
  Refusal take_line(std::string_view& line, bool& stuck);
  Refusal take_chunk_size(bool& stuck);
  Refusal take_chunk_end(bool& stuck);
  Refusal take_trailer(bool& stuck);

  Connection& connection_;
  const Head& head_;
  const std::uint64_t max_bytes_;
  Receive receive_;
  End end_;
  State state_;
  std::uint64_t piece_left_;  // of the body or the chunk
  int trailers_ = 0;
  std::uint64_t bytes_ = 0;
  bool invited_;
  bool consumed_;
};

}  // namespace meshgauge::server
