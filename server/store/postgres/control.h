// The one connection of a process that it keeps for itself: by it the process listens and tells, knows the
// database's time, and is on duty or not. A thread holds it, and gets another one when it is lost.
#pragma once

#include <atomic>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "server/sandbox/descriptor.h"
#include "server/store/postgres/connection.h"
#include "server/store/signals.h"

namespace meshgauge::server::store {

struct ControlSettings {
  std::string database;
  // How long all must have gone well before this process is on duty: a worker that could not be heard during an
  // outage is to have its chance to say that it lives. With new trouble it leaves the duty to others.
  std::chrono::milliseconds duty_grace{15'000};
  std::int64_t time_offset_ns = 0;  // clock_offset_ns(): what time() goes by until it is measured again
  // For how long the duty stays with a process that does not ask for it: each does every second.
  std::chrono::milliseconds duty_lapse{120'000};
};

// Of the database's clock to this machine's steady one.
std::int64_t clock_offset_ns(PgConnection& connection);

class PgControl final : public Signals {
 public:
  // `newest_trouble`: of the other connections of this process.
  PgControl(ControlSettings settings, std::function<SteadyTime()> newest_trouble);
  ~PgControl() override;

  void listen(Hear hear) override;
  void stop_listening() override;

  // To all who listen, this process among them. Returns at once; a little later it is sent, once of several that are
  // equal. What cannot be sent is lost.
  void tell(Signal::Kind kind, const JobKey& job = {});

  TimePoint time() const;  // JobStore::time(). Measured with each connection and every few seconds
  bool on_duty();          // JobStore::on_duty(). Applies for it; who does not call it for duty_lapse leaves it

 private:
  void work();
  void connect();
  void serve();
  void send_pending();
  bool applies() const;  // has asked for the duty of late
  bool is_well() const;  // for the grace
  void seek_duty();
  void apply_for_duty();
  void leave_duty();
  void measure_time();
  void pause();
  void hear(const Signal& signal);
  void hear_all();

  const ControlSettings settings_;
  const std::function<SteadyTime()> newest_trouble_;
  const Descriptor wake_;  // an eventfd

  std::atomic<bool> stopped_{false};
  std::atomic<std::int64_t> asked_{0};  // on_duty(), when last: steady clock's count
  std::atomic<bool> holds_duty_{false};
  std::atomic<std::int64_t> connected_since_;  // steady clock's count
  std::atomic<std::int64_t> time_offset_ns_;   // clock_offset_ns()

  std::mutex pending_mutex_;
  std::deque<std::string> pending_;  // payloads

  std::mutex hear_mutex_;  // held while `hear_` runs
  Hear hear_;

  // The thread's own.
  std::unique_ptr<PgConnection> connection_;
  std::string channel_;
  SteadyTime applied_{}, measured_at_{};
  std::thread thread_;
};

// What a signal is as a payload of NOTIFY, whatever bytes are in its owner's name; one that would be too long becomes
// `missed`. And back; nothing for what is no such payload.
std::string to_payload(const Signal& signal);
std::optional<Signal> signal_of(std::string_view payload);

}  // namespace meshgauge::server::store
