// Comparisons that are measured in parts (docs/sharding.md), as jobs: a part is named after its whole, so that whoever
// holds one knows the other without asking.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "api/compare.h"
#include "api/request.h"
#include "server/store/job_store.h"

namespace meshgauge::server {

struct PartKey {
  store::JobKey whole;
  unsigned index = 0;
};

store::JobKey part_key(const store::JobKey& whole, unsigned index);
std::optional<PartKey> part_of(const store::JobKey& key);  // nullopt: it is no part

// The rows of all parts of a job that is about to be stored.
std::vector<store::NewJob> parts_of(const store::NewJob& whole, unsigned count);

// What the parts, all of which have ended, come to.
struct Together {
  std::optional<api::Comparison> comparison;
  std::string problem;  // JSON text: one of them has failed, and so has the whole. Empty, and no comparison: they do
                        // not make a whole, which has to be measured in one piece
};
Together put_together(std::span<const store::Job> parts, const api::Request& request);

}  // namespace meshgauge::server
