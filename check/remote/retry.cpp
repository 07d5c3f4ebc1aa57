#include "check/remote/retry.h"

#include <algorithm>

namespace meshgauge::check::service {
namespace {

constexpr RetriedStatus kRetried[] = {
    {408, 3},            // the upload was too slow
    {429, 0},            // the key's rate or number of jobs
    {500, 3},            // a proxy's failure, or a defect
    {502, 0},            // a proxy whose service restarts
    {503, 0},            // the queue is full, or the service shuts down
    {504, 0}, {507, 3},  // 507: the disk is full
};

const RetriedStatus* row_of(int status) {
  for (const RetriedStatus& row : kRetried) {
    if (row.status == status) return &row;
  }
  return nullptr;
}

}  // namespace

std::span<const RetriedStatus> retried_statuses() { return kRetried; }

std::optional<Retries::Milliseconds> Retries::after(const net::HttpAnswer& failed, bool reached, Clock::time_point now,
                                                    double random) {
  if (failed.trouble == net::Trouble::hopeless || failed.trouble == net::Trouble::cancelled) return std::nullopt;
  ++tries_;
  if (failed.trouble == net::Trouble::none) {
    const RetriedStatus* row = row_of(failed.status);
    if (!row || (row->tries && tries_ >= row->tries)) return std::nullopt;
  }
  since_ = since_.value_or(now);
  const Milliseconds doubled = kFirst * (1 << std::min(tries_ - 1, 16));
  Milliseconds pause(
      static_cast<std::int64_t>(static_cast<double>(std::min(doubled, kMost).count()) * (1 + random) / 2));
  if (failed.retry_after) pause = std::max<Milliseconds>(pause, *failed.retry_after);
  if (now + pause > *since_ + (reached ? retry_time_ : first_contact_)) return std::nullopt;
  return pause;
}

}  // namespace meshgauge::check::service
