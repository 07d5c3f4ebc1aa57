#include "server/http/body.h"

#include <algorithm>
#include <charconv>

#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr std::size_t kMaxChunkLineBytes = 256;
constexpr int kMaxTrailers = 32;

}  // namespace

Problem not_arrived(Io io, const std::string& what, std::chrono::milliseconds time) {
  if (io == Io::closed) return malformed("the connection was closed before the " + what + " was complete");
  if (io == Io::aborted) {
    return Problem{ProblemKind::shutting_down, "the service shut down before the " + what + " had arrived", {}};
  }
  if (io == Io::peer_limit) {
    return Problem{ProblemKind::too_many_requests,
                   "too many requests from this client address are still arriving; retry in a moment",
                   {}};
  }
  return Problem{ProblemKind::request_timeout,
                 "the " + what + " did not arrive within " + std::to_string(time.count()) + " ms",
                 {}};
}

Body::Body(Connection& connection, const Head& head, std::uint64_t max_bytes, std::chrono::milliseconds time)
    : connection_(connection),
      head_(head),
      max_bytes_(max_bytes),
      time_(time),
      consumed_(!head.chunked && head.content_length.value_or(0) == 0) {}

Body::Refusal Body::read(const Receive& receive) {
  if (consumed_) return std::nullopt;
  deadline_ = Clock::now() + time_;
  // A client that is sending already does not wait for the interim response.
  if (head_.expects_continue && connection_.buffered().empty() &&
      connection_.write("HTTP/1.1 100 Continue\r\n\r\n", deadline_) != Io::ok) {
    return not_arrived(Io::closed, "body", time_);
  }
  auto refusal = head_.chunked ? read_chunked(receive) : read_sized(*head_.content_length, receive);
  consumed_ = !refusal;
  if (consumed_) connection_.release_place();
  return refusal;
}

void Body::discard_arrived() {
  if (consumed_ || head_.chunked) return;
  const std::uint64_t left = *head_.content_length - bytes_;
  if (connection_.buffered().size() < left) return;
  connection_.consume(static_cast<std::size_t>(left));
  consumed_ = true;
  connection_.release_place();
}

Body::Refusal Body::more() {
  const Io io = connection_.fill(deadline_);
  return io == Io::ok ? std::nullopt : Refusal(not_arrived(io, "body", time_));
}

Body::Refusal Body::read_sized(std::uint64_t left, const Receive& receive) {
  while (left > 0) {
    if (connection_.buffered().empty()) {
      if (auto refusal = more()) return refusal;
    }
    const auto piece =
        connection_.buffered().substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(left, SIZE_MAX)));
    bytes_ += piece.size();
    left -= piece.size();
    auto refusal = receive(piece);
    connection_.consume(piece.size());
    if (refusal) return refusal;
  }
  return std::nullopt;
}

Body::Refusal Body::read_chunked(const Receive& receive) {
  for (;;) {
    std::uint64_t size = 0;
    if (auto refusal = read_chunk_size(size)) return refusal;
    if (size == 0) return read_trailers();
    if (size > max_bytes_ - bytes_) {
      return Problem{
          ProblemKind::too_large, "the body is larger than the limit of " + std::to_string(max_bytes_) + " bytes", {}};
    }
    if (auto refusal = read_sized(size, receive)) return refusal;
    if (auto refusal = expect_crlf()) return refusal;
  }
}

// `line` stays valid until the next read from the connection.
Body::Refusal Body::read_line(std::string_view& line) {
  for (;;) {
    const std::string_view buffered = connection_.buffered();
    const std::size_t end = buffered.substr(0, kMaxChunkLineBytes).find("\r\n");
    if (end != std::string_view::npos) {
      line = buffered.substr(0, end);
      // A proxy's parser may take a bare LF for the end of the line.
      return is_field_text(line) ? std::nullopt : Refusal(malformed("a chunk header has a control character"));
    }
    if (buffered.size() >= kMaxChunkLineBytes) {
      return malformed("a chunk header is longer than " + std::to_string(kMaxChunkLineBytes) + " bytes");
    }
    if (auto refusal = more()) return refusal;
  }
}

Body::Refusal Body::read_chunk_size(std::uint64_t& size) {
  std::string_view line;
  if (auto refusal = read_line(line)) return refusal;
  const std::size_t line_bytes = line.size() + 2;
  const std::string_view digits = next(line, ";");  // the rest is a chunk extension, which is ignored
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), size, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    return malformed("a chunk size must be a hexadecimal number");
  }
  connection_.consume(line_bytes);
  return std::nullopt;
}

Body::Refusal Body::expect_crlf() {
  while (connection_.buffered().size() < 2) {
    if (auto refusal = more()) return refusal;
  }
  if (!connection_.buffered().starts_with("\r\n")) return malformed("a chunk must end with CR LF where its size says");
  connection_.consume(2);
  return std::nullopt;
}

Body::Refusal Body::read_trailers() {
  for (int i = 0; i < kMaxTrailers; ++i) {
    std::string_view line;
    if (auto refusal = read_line(line)) return refusal;
    const bool last = line.empty();
    connection_.consume(line.size() + 2);
    if (last) return std::nullopt;
  }
  return malformed("the body has more than " + std::to_string(kMaxTrailers - 1) + " trailers");
}

}  // namespace meshgauge::server
