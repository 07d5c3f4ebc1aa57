// The connection of a process for signals, the database's time and the duty (JobStore::on_duty()). A thread holds it,
// and opens another one when it is lost.
#pragma once

#include <atomic>
#include <deque>
#include <mutex>
#include <string>

#include "api/base/descriptor.h"
#include "server/base/threads.h"
#include "server/store/postgres/connection.h"
#include "server/store/postgres/pool.h"
#include "server/store/signals.h"

namespace meshgauge::server::store {

struct ControlSettings {
  std::string database;
  // How long the database must have answered without trouble before this process is on duty: workers that could not
  // send heartbeats during an outage get time to do so. New trouble ends the duty.
  std::chrono::milliseconds duty_grace{15'000};
  std::int64_t time_offset_ns = 0;  // clock_offset_ns(); time() uses it until it is measured again
  // How long a process stays on duty without calling on_duty(), which each does every second.
  std::chrono::milliseconds duty_lapse{120'000};
};

// The difference of the database's clock and this machine's steady clock.
std::int64_t clock_offset_ns(PgConnection& connection);

class PgControl final : public Signals {
 public:
  // `others`: the other connections of this process; borrowed.
  PgControl(ControlSettings settings, const ConnectionHealth& others);
  ~PgControl() override = default;

  void listen(Hear hear) override;
  void stop_listening() override;

  // Sends a signal to all listeners, this process included, a little later. Returns at once. Equal signals in a row are
  // sent once. A signal that cannot be sent is lost.
  void tell(Signal::Kind kind, const JobKey& job = {});

  TimePoint time() const;  // JobStore::time(), measured with each connection and every few seconds
  bool on_duty();          // JobStore::on_duty(); also applies for the duty, which lapses after duty_lapse

 private:
  void work();
  void tell_end();
  void connect();
  void serve();
  void send_pending();
  bool applies() const;  // on_duty() was called within duty_lapse
  bool is_well() const;  // no trouble within duty_grace
  void seek_duty();
  void apply_for_duty();
  void leave_duty();
  void measure_time();
  void pause();
  void hear(const Signal& signal);
  void hear_all();

  const ControlSettings settings_;
  const ConnectionHealth& others_;
  const Descriptor wake_;  // an eventfd

  std::atomic<bool> stopped_{false};
  std::atomic<std::int64_t> asked_{0};  // newest call of on_duty(): steady clock's count
  std::atomic<bool> holds_duty_{false};
  std::atomic<std::int64_t> connected_since_;  // steady clock's count
  std::atomic<std::int64_t> time_offset_ns_;   // clock_offset_ns()

  std::mutex pending_mutex_;
  std::deque<std::string> pending_;  // payloads

  std::mutex hear_mutex_;  // held while `hear_` runs
  Hear hear_;

  // Used by the thread alone.
  std::unique_ptr<PgConnection> connection_;
  std::string channel_;
  SteadyTime applied_{}, measured_at_{};
  Threads threads_;
};

// A signal as a payload of NOTIFY, for any bytes in the owner's name; a payload that would be too long becomes
// `missed`. signal_of() reads it back; nullopt: not such a payload.
std::string to_payload(const Signal& signal);
std::optional<Signal> signal_of(std::string_view payload);

}  // namespace meshgauge::server::store
