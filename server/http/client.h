// One client's connection, from its first byte to its last: which bytes it is waited for, and until when.
//
//   hello -> handshake -> idle -> head -> serving <-> body | sending | waiting -> idle, or pausing, discarding, leaving
//                 |  ^
//                signing
//
// The event loop's thread does all of this but two things. While `signing`, the connection belongs to the pool of
// handshakes, which takes the costly step in its turn. While `serving`, it belongs to a thread of a pool, which runs
// the handler, takes what has arrived of the body and sends as much of the response as the socket takes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "api/base/problem.h"
#include "server/http/connection.h"
#include "server/http/edge.h"
#include "server/http/event_loop.h"
#include "server/http/serving.h"

namespace meshgauge::server {

class Client final : public EventLoop::Source {
 public:
  Client(Edge& edge, EventLoop& loop, EventLoop::Id id, Descriptor socket);

  void start() override;
  void ready() override;
  void late() override;
  void take(EventLoop::Message message) override;
  void stop() override;
  bool spare() const override;
  Clock::time_point stalled_since() const override;
  void give_way() override;

 private:
  using Step = Transport::Step;
  enum class Phase {
    hello,
    handshake,
    idle,
    head,
    signing,
    serving,
    body,
    sending,
    waiting,
    pausing,
    discarding,
    leaving
  };

  void begin(Phase phase, Clock::time_point deadline);
  void await(Step step);
  void hello();
  void shake_hands(Step step);
  void await_turn();
  void go_on_shaking();
  void await_request();
  void read_head();
  std::optional<api::Problem> check_head(bool& complete);
  void refuse(const api::Problem& problem);
  void serve(Head head, const std::optional<api::Problem>& refusal);
  void go_on();
  void apply(const Serving::State& state);
  void check_gone();
  void keep();
  void begin_discarding();
  void discard();
  void leave();
  void linger();
  void advance();
  void finish();

  Edge& edge_;
  Connection connection_;
  Phase phase_ = Phase::idle;
  Clock::time_point sending_since_{};          // of the phase `sending`, which progress begins anew
  double handshakes_left_ = 0;                 // of its address, when this one was admitted
  Step step_ = Step::closed;                   // of the handshake, from its pool's thread for the loop
  std::unique_ptr<Serving> serving_;           // of the request that is being served
  Serving::State state_ = Serving::End::keep;  // from the pool's thread for the loop
  bool woken_ = false;                         // while serving
  std::uint64_t to_discard_ = 0;               // bytes of a body that was refused
};

}  // namespace meshgauge::server
