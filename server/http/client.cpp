#include "server/http/client.h"

#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <exception>
#include <utility>

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using std::chrono::milliseconds;

constexpr milliseconds kDiscardTime{5'000};  // for the rest of a body that was refused
// Discarding a long rest costs more than a new connection, and most clients that are refused send no more of it.
constexpr std::uint64_t kLongRest = std::uint64_t{256} << 10;
constexpr milliseconds kRefusedPause{10};   // for the client to see the refusal
constexpr milliseconds kLingerTime{1'000};  // for a client to close
constexpr std::size_t kDiscardPiece = std::size_t{1} << 20;

milliseconds ms(std::uint64_t count) { return milliseconds(static_cast<std::int64_t>(count)); }

Clock::time_point in(milliseconds time) { return Clock::now() + time; }

}  // namespace

Client::Client(Edge& edge, EventLoop& loop, EventLoop::Id id, Descriptor socket)
    : Source(loop, id, std::move(socket)), edge_(edge), connection_(fd()) {}

void Client::begin(Phase phase, Clock::time_point deadline) {
  phase_ = phase;
  set_deadline(deadline);
}

void Client::await(Step step) { want(step == Step::wants_write ? EPOLLOUT : EPOLLIN); }

void Client::start() {
  if (!edge_.tls) return await_request();
  set_unfinished(true);
  begin(Phase::hello, in(ms(edge_.settings.keep_alive_ms)));
  await(Step::wants_read);
}

void Client::ready() {
  switch (phase_) {
    case Phase::hello:
      return hello();
    case Phase::handshake:
      return shake_hands(connection_.transport().handshake());
    case Phase::idle:
    case Phase::head:
      return read_head();
    case Phase::body:
    case Phase::sending:
      return go_on();
    case Phase::waiting:
      return check_gone();
    case Phase::pausing:
      return leave();
    case Phase::discarding:
      return discard();
    case Phase::leaving:
      return linger();
    case Phase::signing:
    case Phase::serving:
      return;
  }
}

void Client::late() {
  if (phase_ == Phase::head) return refuse(not_arrived(Lost::timeout, "head", edge_.settings.head_timeout_ms));
  if (phase_ == Phase::waiting || phase_ == Phase::body) return go_on();
  if (phase_ == Phase::sending) return apply(serving_->end(false));
  if (phase_ == Phase::pausing) return begin_discarding();
  if (phase_ == Phase::discarding) return leave();
  if (phase_ == Phase::signing && !edge_.handshakes->withdraw(id())) return set_deadline(Clock::now());  // it returns
  if (phase_ != Phase::serving) close();
}

void Client::take(EventLoop::Message message) {
  if (message == EventLoop::Message::returned) return phase_ == Phase::signing ? go_on_shaking() : apply(state_);
  if (phase_ == Phase::waiting) return go_on();
  woken_ = phase_ == Phase::serving;
}

bool Client::spare() const {
  return phase_ < Phase::signing || phase_ > Phase::waiting;  // what is between may belong to another thread
}

Clock::time_point Client::stalled_since() const {
  return phase_ == Phase::sending ? sending_since_ : Clock::time_point::max();
}

void Client::give_way() {
  if (phase_ == Phase::sending) serving_->end(false);
}

// A client whose request arrives at this moment is told; one that waits for a response gets it.
void Client::stop() {
  if (phase_ == Phase::hello || phase_ == Phase::idle) return close();
  if (!loop().aborting() || phase_ == Phase::serving) return;
  if (phase_ == Phase::signing && !edge_.handshakes->withdraw(id())) return;  // go_on_shaking() closes it
  if (phase_ == Phase::head) return refuse(not_arrived(Lost::aborted, "head", 0));
  if (phase_ == Phase::body) serving_->lose(Lost::aborted);
  if (phase_ == Phase::waiting || phase_ == Phase::body) return go_on();
  if (phase_ == Phase::sending) serving_->end(false);
  close();
}

// A client that sends plain HTTP to the port of TLS gets a 400. One that has gone, or whose address has no handshake
// left, costs nothing more: not even what OpenSSL allocates.
void Client::hello() {
  char first = 0;
  if (::recv(fd(), &first, 1, MSG_DONTWAIT | MSG_PEEK) != 1) return close();
  if (first >= 'A' && first <= 'Z') {  // the first letter of an HTTP method
    set_unfinished(false);
    return refuse(malformed("this port speaks TLS: use https"));
  }
  if (peer_hung_up(fd())) {
    edge_.handshakes->abandon();
    return close();
  }
  const auto left = edge_.handshakes->admit(peer_of(fd()));
  if (!left) return close();
  handshakes_left_ = *left;
  connection_.secure(edge_.tls->accept(fd()));
  begin(Phase::handshake, in(ms(edge_.settings.head_timeout_ms)));
  shake_hands(connection_.transport().handshake());
}

void Client::shake_hands(Step step) {
  if (step == Step::wants_thread) return await_turn();
  if (step == Step::done) {
    set_unfinished(false);
    return await_request();
  }
  if (step == Step::closed || !connection_.take_place(edge_.peers)) return close();
  await(step);
}

// The deadline of the handshake goes on. The loop may destroy this object from the message on.
void Client::await_turn() {
  phase_ = Phase::signing;
  set_unfinished(false);
  const auto on_turn = [this, inbox = loop().inbox()](Handshake::Turn turn) {
    step_ = turn == Handshake::Turn::run ? connection_.transport().handshake() : Step::closed;
    inbox->post(id(), EventLoop::Message::returned);
  };
  edge_.handshakes->offer({id(), fd(), handshakes_left_, on_turn});
}

void Client::go_on_shaking() {
  if (loop().aborting()) return close();
  phase_ = Phase::handshake;
  set_unfinished(true);
  shake_hands(step_);
}

void Client::await_request() {
  connection_.release_place();
  const bool arrived = !connection_.buffered().empty();
  if (loop().stopping() && !arrived) return leave();
  if (loop().aborting()) return refuse(not_arrived(Lost::aborted, "head", 0));
  connection_.shrink();
  begin(arrived ? Phase::head : Phase::idle,
        in(ms(arrived ? edge_.settings.head_timeout_ms : edge_.settings.keep_alive_ms)));
  // Bytes that TLS has decrypted already make no event.
  arrived || edge_.tls ? soon() : await(Step::wants_read);
}

std::optional<Problem> Client::check_head(bool& complete) {
  while (connection_.buffered().starts_with("\r\n")) connection_.consume(2);  // RFC 9112 section 2.2
  const std::string_view buffered = connection_.buffered();
  complete = buffered.substr(0, kMaxHeadBytes).find("\r\n\r\n") != std::string_view::npos;
  return complete ? std::nullopt : check_incomplete(buffered);
}

// One read for each turn of the loop: with updates of keys between the bytes of a head, TLS would be read for as long
// as the client sends them.
void Client::read_head() {
  for (bool received = false;; received = true) {
    bool complete = false;
    if (const auto refusal = check_head(complete)) return refuse(*refusal);
    if (complete) {
      const std::string_view buffered = connection_.buffered();
      const std::string text(buffered.substr(0, buffered.find("\r\n\r\n") + 4));
      connection_.consume(text.size());
      Head head;
      const auto refusal = parse_head(text, edge_.settings.max_request_bytes, head);
      return serve(std::move(head), refusal);
    }
    if (received) return soon();
    const Step step = connection_.receive(Connection::kHeadPiece);
    if (step == Step::done) {
      if (phase_ == Phase::idle) begin(Phase::head, in(ms(edge_.settings.head_timeout_ms)));
      continue;
    }
    const bool closed = step == Step::closed;
    if (phase_ == Phase::idle) return closed ? close() : await(step);
    if (closed) return refuse(not_arrived(Lost::closed, "head", 0));
    if (!connection_.take_place(edge_.peers)) return refuse(not_arrived(Lost::peer_limit, "head", 0));
    return await(step);
  }
}

void Client::refuse(const Problem& problem) { serve(Head{}, problem); }

void Client::serve(Head head, const std::optional<Problem>& refusal) {
  const bool has_body = head.chunked || head.content_length.value_or(0) > 0;
  if (!refusal && !has_body) connection_.release_place();
  serving_ =
      std::make_unique<Serving>(edge_, loop(), connection_, std::move(head), refusal,
                                [inbox = loop().inbox(), id = id()] { inbox->post(id, EventLoop::Message::woken); });
  begin(Phase::serving, Clock::time_point::max());
  const auto entry = refusal ? RequestHandler::Entry::answered : serving_->enter();
  if (entry == RequestHandler::Entry::answered) {
    if (may_retry(serving_->exchange().response.status)) count_refusal();
    return apply(serving_->advance());
  }
  IoPool& pool = entry == RequestHandler::Entry::status ? edge_.status : edge_.requests;
  const bool taken = pool.offer([this] {
    serving_->handle();
    advance();
  });
  if (taken) return;
  count_refusal();
  answer(serving_->exchange(), Problem{ProblemKind::overloaded, "all threads are in use; retry in a moment"});
  apply(serving_->advance());
}

// Text is written by the loop itself. What may block goes to the pool: handlers, what takes a body, and files that are
// not in memory.
void Client::go_on() {
  if (serving_->is_quick()) return apply(serving_->advance());
  begin(Phase::serving, Clock::time_point::max());
  edge_.requests.push([this] { advance(); });
}

void Client::apply(const Serving::State& state) {
  if (const auto* step = std::get_if<Step>(&state)) {
    begin(serving_->receiving() ? Phase::body : Phase::sending, serving_->deadline());
    sending_since_ = Clock::now();
    return loop().aborting() ? stop() : await(*step);
  }
  if (const auto* due = std::get_if<Clock::time_point>(&state)) {
    begin(Phase::waiting, *due);
    if (std::exchange(woken_, false)) return go_on();
    if (!serving_->exchange().client_gone) want(EPOLLRDHUP | (edge_.tls ? std::uint32_t{EPOLLIN} : 0U));
    return;
  }
  woken_ = false;
  if (serving_) finish();
  std::get<Serving::End>(state) == Serving::End::keep ? keep() : leave();
}

void Client::finish() {
  to_discard_ = serving_->to_discard();
  serving_.reset();
}

void Client::check_gone() {
  if (!connection_.transport().peer_gone()) return want(EPOLLRDHUP);  // TLS: another request has arrived already
  serving_->exchange().client_gone = true;
  go_on();
}

// After a refusal the rest of the body is discarded: a new connection would cost more.
void Client::keep() {
  const auto arrived = std::min<std::uint64_t>(to_discard_, connection_.buffered().size());
  connection_.consume(static_cast<std::size_t>(arrived));
  to_discard_ -= arrived;
  if (to_discard_ == 0) return await_request();
  if (to_discard_ < kLongRest) return begin_discarding();
  begin(Phase::pausing, in(kRefusedPause));
  want(EPOLLRDHUP);
}

void Client::begin_discarding() {
  begin(Phase::discarding, in(kDiscardTime));
  discard();
}

void Client::discard() {
  const auto most = std::min<std::uint64_t>(to_discard_, kDiscardPiece);
  const auto moved = connection_.transport().discard(static_cast<std::size_t>(most));
  to_discard_ -= moved.bytes;
  if (moved.step == Step::closed) return close();
  if (to_discard_ == 0) return await_request();
  moved.step == Step::done ? soon() : await(moved.step);
}

// Closing a socket with unread bytes resets the connection, and the client may lose the response. So the service ends
// its own direction, and discards what still arrives until the client closes as well.
void Client::leave() {
  if (loop().aborting()) return close();
  connection_.transport().end();
  to_discard_ = Serving::kMostDiscarded;
  begin(Phase::leaving, in(kLingerTime));
  linger();
}

void Client::linger() {
  const auto moved = PlainTransport(fd()).discard(static_cast<std::size_t>(to_discard_));
  to_discard_ -= moved.bytes;
  if (moved.step == Step::closed || to_discard_ == 0) return close();
  await(Step::wants_read);
}

// On a thread of a pool. The loop may destroy this object from the message on.
void Client::advance() {
  const auto inbox = loop().inbox();
  try {
    state_ = serving_->advance();
  } catch (const std::exception&) {  // no memory for the response
    state_ = Serving::End::close;
  }
  if (std::holds_alternative<Serving::End>(state_)) finish();  // here: it may have files to close
  inbox->post(id(), EventLoop::Message::returned);
}

}  // namespace meshgauge::server
