#include "server/http/serving.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <exception>
#include <utility>

#include "api/base/digest.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr std::size_t kFilePiece = std::size_t{1} << 20;
constexpr milliseconds kFilePieceTime{10'000};
constexpr std::size_t kLeastFileBytesPerMs = 512;
// Other requests wait for the place and the bytes that an upload holds: it may stop for this share of its time.
constexpr int kStallShare = 8;
constexpr milliseconds kLeastStall{1000};
constexpr milliseconds kSilence{15'000};  // proxies close connections that are silent for longer

Clock::time_point after(milliseconds time) { return Clock::now() + time; }

constexpr std::size_t kMostHeadBytes = 1024;  // of nearly all responses

std::string_view reason_of(int status) {
  constexpr std::array<std::pair<int, std::string_view>, 26> kReasons{{
      {200, "OK"},
      {201, "Created"},
      {202, "Accepted"},
      {204, "No Content"},
      {304, "Not Modified"},
      {400, "Bad Request"},
      {401, "Unauthorized"},
      {403, "Forbidden"},
      {404, "Not Found"},
      {405, "Method Not Allowed"},
      {408, "Request Timeout"},
      {409, "Conflict"},
      {410, "Gone"},
      {411, "Length Required"},
      {413, "Content Too Large"},
      {414, "URI Too Long"},
      {415, "Unsupported Media Type"},
      {422, "Unprocessable Content"},
      {429, "Too Many Requests"},
      {431, "Request Header Fields Too Large"},
      {500, "Internal Server Error"},
      {501, "Not Implemented"},
      {503, "Service Unavailable"},
      {504, "Gateway Timeout"},
      {505, "HTTP Version Not Supported"},
      {507, "Insufficient Storage"},
  }};
  const auto* found =
      std::find_if(kReasons.begin(), kReasons.end(), [&](const auto& row) { return row.first == status; });
  return found == kReasons.end() ? "" : found->second;
}

// A value with a line break or another control character is left out: it would begin a header of its own.
void add_header(std::string& head, std::string_view name, std::string_view value) {
  if (is_field_text(value)) head.append(name).append(": ").append(value).append("\r\n");
}

std::string head_of(const Response& response, std::string_view framing, std::string_view size, bool close) {
  std::string head;
  head.reserve(kMostHeadBytes + response.body.size());
  head.append("HTTP/1.1 ").append(std::to_string(response.status)).append(" ");
  head.append(reason_of(response.status)).append("\r\n");
  if (has_content(response.status)) add_header(head, "Content-Type", response.content_type);
  for (const auto& [name, value] : response.headers) add_header(head, name, value);
  if (has_content(response.status) && !framing.empty()) add_header(head, framing, size);  // RFC 9110 section 8.6
  if (close) add_header(head, "Connection", "close");
  return head.append("\r\n");
}

// RFC 9112 section 7.1. Precondition: `piece` is not empty, since an empty chunk ends a body.
std::string chunk(std::string_view piece) {
  char size[20];
  std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
  return size + std::string(piece) + "\r\n";
}

}  // namespace

Problem not_arrived(Lost why, const std::string& what, std::uint64_t time_ms) {
  switch (why) {
    case Lost::closed:
      return malformed("the connection was closed before the " + what + " was complete");
    case Lost::aborted:
      return {ProblemKind::shutting_down, "the service shut down before the " + what + " had arrived"};
    case Lost::peer_limit:
      return {ProblemKind::too_many_requests,
              "too many requests from this client address are still arriving; retry in a moment"};
    case Lost::stalled:
      return {ProblemKind::request_timeout,
              "no byte of the " + what + " arrived for " + std::to_string(time_ms) + " ms"};
    case Lost::timeout:
      break;
  }
  return {ProblemKind::request_timeout, "the " + what + " did not arrive within " + std::to_string(time_ms) + " ms"};
}

Transport::Step Outgoing::write(Transport& transport, std::string_view bytes, std::size_t& sent) {
  while (sent < bytes.size()) {
    const Transport::Moved moved = transport.write(bytes.substr(sent));
    if (moved.step != Transport::Step::done) return moved.step;
    sent += moved.bytes;
    written_ += moved.bytes;
  }
  return Transport::Step::done;
}

Transport::Step Outgoing::write(Transport& transport) {
  if (const auto step = write(transport, text_, text_sent_); step != Transport::Step::done) return step;
  text_.clear();
  text_sent_ = 0;
  const std::string_view rest(reinterpret_cast<const char*>(file_.bytes.data()), file_.bytes.size());
  std::size_t sent = 0;
  const auto step = write(transport, rest.substr(0, std::min(rest.size(), kFilePiece)), sent);
  file_.bytes = file_.bytes.subspan(sent);
  if (file_.bytes.empty()) file_ = {};
  return step;
}

Serving::Serving(Edge& edge, const EventLoop& loop, Connection& connection, Head head,
                 const std::optional<Problem>& refusal, std::function<void()> wake)
    : edge_(edge),
      loop_(loop),
      connection_(connection),
      head_(std::move(head)),
      body_(connection, head_, edge.settings.max_request_bytes),
      exchange_(api::random_id(), head_, body_),
      close_(refusal.has_value() || !head_.keep_alive) {
  exchange_.peer = connection.peer();
  exchange_.wake = std::move(wake);
  if (refusal) answer(exchange_, *refusal);
}

bool Serving::is_quick() const {
  const Response& response = exchange_.response;
  const bool calls = response.later || response.stream || body_.reading();
  return !outgoing_.has_file() && (!calls || response.quick);
}

RequestHandler::Entry Serving::enter() {
  try {
    return edge_.handler.enter(exchange_);
  } catch (const std::exception& error) {
    fail(error);
    return RequestHandler::Entry::answered;
  }
}

void Serving::handle() {
  try {
    edge_.handler.handle(exchange_);
  } catch (const std::exception& error) {
    fail(error);
  }
}

void Serving::fail(const std::exception& error) {
  exchange_.failure = error.what();
  body_.abandon();
  answer(exchange_, Problem{ProblemKind::internal,
                            "internal error; the service's log has the cause under the id " + exchange_.id});
}

// Writes what there is of the response and makes more of it, until it has to wait or has ended.
Serving::State Serving::advance() {
  if (body_.reading()) {
    if (const Step step = receive_body(); step != Step::done) return step;
  }
  if (!composed_) {
    if (const auto due = make_response()) return *due;
    compose();
  }
  for (;;) {
    while (!outgoing_.empty()) {
      const Step step = outgoing_.write(connection_.transport());
      if (step == Step::closed) return end(false);
      if (step != Step::done) return step;
      deadline_ = std::min(latest_, after(kFilePieceTime));
    }
    if (!exchange_.response.stream) return end(true);
    Clock::time_point due;
    if (exchange_.client_gone || stands_still() || !add_piece(due)) return end(false);
    if (outgoing_.empty()) return due;
  }
}

// done: the handler has got the whole body, or why there is none.
Serving::Step Serving::receive_body() {
  const milliseconds time(static_cast<std::int64_t>(edge_.settings.body_timeout_ms));
  const milliseconds pause = std::max(kLeastStall, time / kStallShare);
  if (!deadline_) {
    body_latest_ = after(time);
    deadline_ = std::min(body_latest_, after(pause));
  }
  if (Clock::now() >= body_latest_) lost_ = Lost::timeout;  // also when bytes keep coming
  try {
    const std::uint64_t before = body_.bytes();
    const Step step = lost_ ? Step::closed : body_.go_on();
    if (step == Step::done) {
      if (body_.consumed()) connection_.release_place();
      return Step::done;
    }
    const auto now = Clock::now();
    if (body_.bytes() > before) deadline_ = std::min(body_latest_, now + pause);
    if (!lost_ && step != Step::closed && now >= *deadline_) lost_ = Lost::stalled;
    if (!lost_ && step != Step::closed && connection_.take_place(edge_.peers)) return step;
    if (!lost_) lost_ = step == Step::closed ? Lost::closed : Lost::peer_limit;
    body_.stop(
        not_arrived(*lost_, "body", static_cast<std::uint64_t>((lost_ == Lost::stalled ? pause : time).count())));
  } catch (const std::exception& error) {
    fail(error);
  }
  return Step::done;
}

// Returns when to try again; nullopt: the response is made.
std::optional<Clock::time_point> Serving::make_response() {
  if (!exchange_.response.later) return std::nullopt;
  auto later = std::exchange(exchange_.response.later, nullptr);
  try {
    const auto due = later(exchange_);
    if (due) exchange_.response.later = std::move(later);
    return due;
  } catch (const std::exception& error) {
    fail(error);
    return std::nullopt;
  }
}

void Serving::compose() {
  Response& response = exchange_.response;
  response.headers.emplace_back("X-Request-Id", exchange_.id);
  for (auto& header : trace_headers(exchange_.trace)) response.headers.push_back(std::move(header));
  add_security_headers(response);
  // The unread rest of a body would be parsed as the next request.
  const bool keeps = body_.consumed() || (may_retry(response.status) && body_.left() <= kMostDiscarded);
  if (!keeps || loop_.stopping() || response.stream) close_ = true;
  moved_ = Clock::now();
  deadline_ = moved_ + edge_.write_time;
  composed_ = true;
  const std::string_view length = response.length_known ? "Content-Length" : "";
  const bool has_body = head_.method != "HEAD" && has_content(response.status);
  if (response.stream) {
    outgoing_.add(head_of(response, "Transfer-Encoding", "chunked", true));
  } else if (response.file) {
    const std::size_t size = response.file->bytes.size();
    latest_ = *deadline_ + milliseconds(size / kLeastFileBytesPerMs);
    outgoing_.add(head_of(response, length, std::to_string(size), close_));
    if (has_body) outgoing_.add(*std::exchange(response.file, std::nullopt));
  } else {
    std::string text = head_of(response, length, std::to_string(response.body.size()), close_);
    if (has_body) text += response.body;
    outgoing_.add(std::move(text));
  }
}

// Whether the client of a stream has taken nothing for Edge::write_time of what the kernel holds for it. The kernel
// takes small pieces for hours, and a stream that is never read would keep its place from one that is.
bool Serving::stands_still() {
  const auto now = Clock::now();
  const std::uint64_t unsent = connection_.unsent();
  if (unsent == 0 || unsent < unsent_ + outgoing_.written() - written_by_then_) moved_ = now;
  unsent_ = unsent;
  written_by_then_ = outgoing_.written();
  return now - moved_ >= edge_.write_time;
}

// Adds the next piece of a stream, if there is one; else sets `due` to when to ask again. False: the stream failed.
bool Serving::add_piece(Clock::time_point& due) {
  std::string piece;
  std::optional<Clock::time_point> next;
  try {
    next = exchange_.response.stream(piece);
  } catch (const std::exception& error) {
    exchange_.failure = error.what();
    return false;
  }
  const auto now = Clock::now();
  if (piece.empty() && next && now >= last_piece_ + kSilence) piece = ": still here\n\n";
  if (!piece.empty()) {
    outgoing_.add(chunk(piece));
    last_piece_ = now;
  }
  if (!next) {
    outgoing_.add("0\r\n\r\n");
    exchange_.response.stream = nullptr;
  }
  deadline_ = now + edge_.write_time;
  due = std::min(next.value_or(now), last_piece_ + kSilence);
  return true;
}

Serving::State Serving::end(bool delivered) {
  exchange_.bytes_out = outgoing_.written();
  exchange_.delivered = delivered;
  exchange_.response.later = nullptr;  // before the log: these hold places
  exchange_.response.stream = nullptr;
  exchange_.response.file.reset();
  outgoing_ = {};
  edge_.handler.log(exchange_);
  return delivered && !close_ ? End::keep : End::close;
}

}  // namespace meshgauge::server
