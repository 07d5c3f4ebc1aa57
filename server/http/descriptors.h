// How many descriptors a process may have, and how many connections they leave room for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "engine/result.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

inline constexpr std::size_t kStatusConnections = 64;  // of the status_port

struct DescriptorPlan {
  std::uint64_t limit = 0;      // of the process
  std::uint64_t needed = 0;     // for uploads, reader processes, stores and the status_port
  std::size_t connections = 0;  // that may be open; 0: the limit is too low to serve
};

// Raises the limit to the hard one (the soft one is often 1024). Connections may take three quarters of it, and less
// where that would not leave what is needed. Precondition: settings come from checked().
DescriptorPlan plan_descriptors(const Settings& settings);

// Splits `limit` for the settings.
DescriptorPlan planned(const Settings& settings, std::uint64_t limit);

// An Error if the limit is too low to serve with these settings. It says what they need, and what to do.
Result<Done> check_descriptors(const Settings& settings);

std::string descriptors_text(const Settings& settings);  // for the log: the plan, in words

}  // namespace meshgauge::server
