// Whether a process can do its work: GET /readyz.
#pragma once

#include <condition_variable>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/http/exchange.h"
#include "server/jobs/stores.h"

namespace meshgauge::server {

// Thread safe, but for watch().
class Readiness {
 public:
  // `timeout`: for how long one look holds up who asks; a part that takes longer does not answer.
  explicit Readiness(std::chrono::milliseconds timeout = std::chrono::milliseconds(1500)) : timeout_(timeout) {}
  ~Readiness();  // waits for a look that goes on

  using Defects = std::vector<std::pair<const char*, std::string>>;  // a part, and what is wrong with it

  // `look` says what is not in order with a part, or is empty. Asked once a second at most, by one thread at a time;
  // whoever asks meanwhile is told what was seen before. Before the first answer.
  void watch(const char* part, std::function<std::string()> look) { looks_.emplace_back(part, std::move(look)); }
  void watch_stores(const Stores& stores);  // borrows them; what one part says already, the next does not repeat

  // Ready, or a problem with `now` and what was seen: every defect is named, so that whoever reads it need not ask
  // again.
  void answer(Exchange& exchange, Defects now);
  Defects seen();  // without `now`

 private:
  Defects late() const { return {{at_, "it does not answer in time"}}; }
  void begin_look();
  void check();
  Defects find_defects();

  const std::chrono::milliseconds timeout_;
  std::vector<std::pair<const char*, std::function<std::string()>>> looks_;
  std::mutex mutex_;  // guards what follows; nobody looks under it
  std::condition_variable looked_at_;
  bool looking_ = false;  // a thread does
  bool late_ = false;     // for longer than anybody's timeout
  const char* at_ = "";   // the part that it looks at
  Defects defects_;
  Clock::time_point looked_{};
  std::future<void> check_;
};

// GET /healthz: it answers.
void answer_health(Exchange& exchange);

}  // namespace meshgauge::server
