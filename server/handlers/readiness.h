// Readiness of a process: GET /readyz.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/http/exchange.h"
#include "server/http/router.h"
#include "server/measure/stores.h"
#include "server/observe/metrics.h"

namespace meshgauge::server {

// Runs checks of the parts that a process needs, at most once a second, and answers from their last result. Logs a part
// once when it fails and once when it is well again. Thread safe, except for add_check() and add_store_checks().
class Readiness {
 public:
  // `timeout`: maximum time that one request waits for the checks. A part whose check takes longer counts as not ready.
  explicit Readiness(std::chrono::milliseconds timeout = std::chrono::milliseconds(1500)) : timeout_(timeout) {}
  ~Readiness();  // waits for checks that are running

  using Defects = std::vector<std::pair<const char*, std::string>>;  // a part, and what is wrong with it

  // Adds a check of `part`. It returns what is wrong with the part, or an empty text; it may block or throw. One thread
  // at a time runs the checks. Call before the first answer(). `place`: where the part is, for the log alone.
  void add_check(const char* part, std::function<std::string()> check, std::string place = "") {
    checks_.push_back({part, std::move(check), std::move(place)});
  }
  // Adds the checks of the job store and the blob store, which must outlive this object.
  void add_store_checks(const Stores& stores);

  // Answers 200, or the problem not-ready that names every defect: those in `now` and those of last_defects().
  void answer(Exchange& exchange, Defects now);

  // Returns the defects that the last checks found, a message that two parts share once. Starts new checks when the
  // last ones ended more than a second ago, and waits for them for the timeout at most; while another thread runs them,
  // returns the result before.
  Defects last_defects();

 private:
  struct Check {
    const char* part;
    std::function<std::string()> find_defect;
    std::string place;
    bool failed = false;  // the last time
  };

  static void tell(Check& check, const std::string& defect);
  Defects overdue() const;
  void start_checks();
  void run_checks();
  Defects find_defects();

  const std::chrono::milliseconds timeout_;
  std::vector<Check> checks_;
  std::mutex mutex_;  // guards what follows; no check runs under it
  std::condition_variable checks_ended_;
  bool checking_ = false;          // a thread runs the checks
  bool overdue_ = false;           // it has for longer than timeout_
  const char* current_part_ = "";  // the part that it checks
  Defects defects_;
  Clock::time_point checked_at_{};
  std::future<void> running_checks_;
};

// Adds /healthz, which is 200 as long as the process answers at all, /metrics, and /readyz, which `ready` answers.
void add_status_routes(Router& router, const Metrics& metrics, Router::Action ready);

}  // namespace meshgauge::server
