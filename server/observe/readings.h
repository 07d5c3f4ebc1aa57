// Metrics that are read on scrape: levels of their owners, the sandbox's counters, and this process's resources.
#pragma once

#include <functional>
#include <map>
#include <vector>

#include <prometheus/metric_family.h>

#include "server/observe/metrics.h"

namespace meshgauge::server {

class Readings {
 public:
  void watch(Level level, std::function<double()> read) { levels_[level] = std::move(read); }
  void watch_sandbox(std::function<sandbox::Counters()> read) { sandbox_ = std::move(read); }

  void append_to(std::vector<prometheus::MetricFamily>& families) const;  // reads them all

 private:
  std::map<Level, std::function<double()>> levels_;
  std::function<sandbox::Counters()> sandbox_;
};

}  // namespace meshgauge::server
