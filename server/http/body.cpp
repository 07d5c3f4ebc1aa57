#include "server/http/body.h"

#include <algorithm>
#include <charconv>
#include <limits>

#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr std::size_t kMaxChunkLineBytes = 256;
constexpr int kMaxTrailers = 32;

}  // namespace

Body::Body(Connection& connection, const Head& head, std::uint64_t max_bytes)
    : connection_(connection),
      head_(head),
      max_bytes_(max_bytes),
      state_(head.chunked ? State::chunk_size : State::sized),
      piece_left_(head.content_length.value_or(0)),
      invited_(!head.expects_continue),
      consumed_(!head.chunked && piece_left_ == 0) {}

void Body::read(Receive receive, End end) {
  receive_ = std::move(receive);
  end_ = std::move(end);
}

void Body::stop(const Refusal& refusal) {
  receive_ = nullptr;
  std::exchange(end_, nullptr)(refusal);
}

void Body::abandon() {
  receive_ = nullptr;
  end_ = nullptr;
}

// A client that is sending already does not wait for the interim response.
bool Body::invite() {
  constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
  if (std::exchange(invited_, true) || consumed_ || !connection_.buffered().empty()) return true;
  return connection_.transport().write(kContinue).bytes == kContinue.size();  // false: it reads no responses
}

Body::Step Body::go_on() {
  if (!invite()) return Step::closed;
  while (!consumed_) {
    bool stuck = false;
    if (auto refusal = take(stuck)) return stop(refusal), Step::done;
    if (!stuck) continue;
    const Step step = connection_.receive(Connection::kBodyPiece);
    if (step != Step::done) return step;
  }
  stop(std::nullopt);
  return Step::done;
}

std::uint64_t Body::left() const {
  if (consumed_) return 0;
  const bool known = !head_.chunked && (invited_ || !connection_.buffered().empty());
  return known ? piece_left_ : std::numeric_limits<std::uint64_t>::max();
}

// Takes one element of the body from the buffer. `stuck`: more bytes are needed.
Body::Refusal Body::take(bool& stuck) {
  switch (state_) {
    case State::sized:
    case State::chunk:
      return take_bytes(stuck);
    case State::chunk_size:
      return take_chunk_size(stuck);
    case State::chunk_end:
      return take_chunk_end(stuck);
    case State::trailers:
      return take_trailer(stuck);
  }
  return std::nullopt;
}

Body::Refusal Body::take_bytes(bool& stuck) {
  const auto piece = connection_.buffered().substr(
      0, static_cast<std::size_t>(std::min<std::uint64_t>(piece_left_, std::numeric_limits<std::size_t>::max())));
  if (piece.empty()) return stuck = true, std::nullopt;
  bytes_ += piece.size();
  piece_left_ -= piece.size();
  auto refusal = receive_(piece);
  connection_.consume(piece.size());
  if (refusal || piece_left_ > 0) return refusal;
  state_ == State::sized ? void(consumed_ = true) : void(state_ = State::chunk_end);
  return std::nullopt;
}

// `line` stays valid until the next read from the connection; the caller consumes it and its CR LF.
Body::Refusal Body::take_line(std::string_view& line, bool& stuck) {
  const std::string_view buffered = connection_.buffered();
  const std::size_t end = buffered.substr(0, kMaxChunkLineBytes).find("\r\n");
  if (end == std::string_view::npos) {
    stuck = buffered.size() < kMaxChunkLineBytes;
    if (stuck) return std::nullopt;
    return malformed("a chunk header is longer than " + std::to_string(kMaxChunkLineBytes) + " bytes");
  }
  line = buffered.substr(0, end);
  // A proxy's parser may take a bare LF for the end of the line.
  return is_field_text(line) ? std::nullopt : Refusal(malformed("a chunk header has a control character"));
}

Body::Refusal Body::take_chunk_size(bool& stuck) {
  std::string_view line;
  if (auto refusal = take_line(line, stuck); refusal || stuck) return refusal;
  const std::size_t line_bytes = line.size() + 2;
  const std::string_view digits = next(line, ";");  // the rest is a chunk extension, which is ignored
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), piece_left_, 16);
  if (error != std::errc() || end != digits.data() + digits.size()) {
    return malformed("a chunk size must be a hexadecimal number");
  }
  connection_.consume(line_bytes);
  if (piece_left_ > max_bytes_ - bytes_) {
    return Problem{ProblemKind::too_large,
                   "the body is larger than the limit of " + std::to_string(max_bytes_) + " bytes"};
  }
  state_ = piece_left_ == 0 ? State::trailers : State::chunk;
  return std::nullopt;
}

Body::Refusal Body::take_chunk_end(bool& stuck) {
  stuck = connection_.buffered().size() < 2;
  if (stuck) return std::nullopt;
  if (!connection_.buffered().starts_with("\r\n")) return malformed("a chunk must end with CR LF where its size says");
  connection_.consume(2);
  state_ = State::chunk_size;
  return std::nullopt;
}

Body::Refusal Body::take_trailer(bool& stuck) {
  if (trailers_ == kMaxTrailers) {
    return malformed("the body has more than " + std::to_string(kMaxTrailers - 1) + " trailers");
  }
  std::string_view line;
  if (auto refusal = take_line(line, stuck); refusal || stuck) return refusal;
  ++trailers_;
  consumed_ = line.empty();
  connection_.consume(line.size() + 2);
  return std::nullopt;
}

}  // namespace meshgauge::server
