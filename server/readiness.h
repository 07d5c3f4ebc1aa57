// Whether a process can do its work: GET /readyz.
#pragma once

#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "server/exchange.h"
#include "server/jobs/stores.h"

namespace meshgauge::server {

// Thread safe, but for watch().
class Readiness {
 public:
  using Defects = std::vector<std::pair<const char*, std::string>>;  // a part, and what is wrong with it

  // `look` says what is not in order with a part, or is empty. Asked once a second at most, by one thread at a time;
  // whoever asks meanwhile is told what was seen before. Before the first answer.
  void watch(const char* part, std::function<std::string()> look) { looks_.emplace_back(part, std::move(look)); }
  void watch_stores(const Stores& stores);  // borrows them

  // Ready, or a problem with `now` and what was seen: every defect is named, so that whoever reads it need not ask
  // again.
  void answer(Exchange& exchange, Defects now);

 private:
  Defects seen();
  Defects look() const;

  std::vector<std::pair<const char*, std::function<std::string()>>> looks_;
  std::mutex mutex_;      // guards what follows; nobody looks under it
  bool looking_ = false;  // a thread does
  Defects defects_;
  Clock::time_point looked_{};
};

// GET /healthz: it answers.
void answer_health(Exchange& exchange);

}  // namespace meshgauge::server
