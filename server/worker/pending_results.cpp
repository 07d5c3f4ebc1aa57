#include "server/worker/pending_results.h"

#include <algorithm>
#include <iterator>
#include <new>
#include <utility>

#include "server/base/heap.h"
#include "server/observe/log.h"

namespace meshgauge::server {
namespace {

std::uint64_t bytes_of(const PendingResult& delivery) {
  return delivery.ending ? delivery.ending->document.size() + delivery.ending->problem.size() : 0;
}

// Errors that may pass; after others a repetition would fail again.
bool may_pass(const Error& error) {
  return error.code == ErrorCode::storage_full || error.code == ErrorCode::storage_unavailable;
}

const store::Token& token_of(const PendingResult& delivery) { return delivery.job->token; }

}  // namespace

PendingResults::PendingResults(store::JobStore& jobs, Settings settings, Listener& listener)
    : jobs_(jobs), settings_(settings), listener_(listener), threads_([this] { tell_end(); }) {
  threads_.start([this] { deliver_in_background(); });
}

void PendingResults::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_all();
}

void PendingResults::add(PendingResult delivery) {
  {
    const std::lock_guard lock(mutex_);
    ++unsettled_;
    unsettled_bytes_ += bytes_of(delivery);
    waiting_.push_back(std::move(delivery));
  }
  wake_.notify_all();
}

void PendingResults::hurry() {
  {
    const std::lock_guard lock(mutex_);
    hurry_ = true;
  }
  wake_.notify_all();
}

std::size_t PendingResults::waiting() const {
  const std::lock_guard lock(mutex_);
  return unsettled_;
}

bool PendingResults::full() const {
  const std::lock_guard lock(mutex_);
  return unsettled_ >= kFull || unsettled_bytes_ >= kFullBytes;
}

bool PendingResults::wait_until_empty(Clock::time_point until) const {
  std::unique_lock lock(mutex_);
  return emptied_.wait_until(lock, until, [&] { return unsettled_ == 0; });
}

void PendingResults::deliver_in_background() {
  const NeverFails never_fails;
  auto pause = settings_.first_pause;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (ending_) return;
    Group group = next_group();
    hurry_ = false;
    lock.unlock();
    const bool through = deliver(group);
    lock.lock();
    if (through) {
      pause = settings_.first_pause;
      continue;
    }
    waiting_.insert(waiting_.end(), std::make_move_iterator(group.begin()), std::make_move_iterator(group.end()));
    if (pause == settings_.first_pause)
      log_event("store", std::to_string(unsettled_) + " ended jobs wait for the store");
    if (hurry_) pause = settings_.first_pause;
    wake_.wait_for(lock, pause, [&] { return ending_ || hurry_; });
    pause = std::min(2 * pause, settings_.longest_pause);
  }
}

// Returns consecutive endings, or one hand-back. Precondition: mutex_ is held and a result waits.
PendingResults::Group PendingResults::next_group() {
  Group group;
  std::uint64_t bytes = 0;
  while (!waiting_.empty() && group.size() < kGroup && bytes < kGroupBytes) {
    if (!group.empty() && !(waiting_.front().ending && group.back().ending)) break;
    bytes += bytes_of(waiting_.front());
    group.push_back(std::move(waiting_.front()));
    waiting_.pop_front();
  }
  return group;
}

// Stores the group; false: some of it is left, for a later attempt. std::bad_alloc counts as an error that may pass.
bool PendingResults::deliver(Group& group) try {
  auto error = group.front().ending ? store_endings(group) : give_back(group.front());
  if (error && !may_pass(*error)) {
    listener_.failed(*error);
    error = one_by_one(group);
  } else if (!error) {
    group.clear();
  }
  if (error) listener_.failed(*error);
  return group.empty();
} catch (const std::bad_alloc&) {
  return false;
}

std::optional<Error> PendingResults::store_endings(Group& group) {
  std::vector<store::Finished> endings;
  endings.reserve(group.size());
  for (const PendingResult& delivery : group) endings.push_back({token_of(delivery), *delivery.ending});
  const auto stored = jobs_.finish_all(endings);
  if (!stored) return stored.error();
  std::size_t settled = 0;
  try {
    for (; settled < group.size(); ++settled) {
      settle(group[settled], (*stored)[settled] ? Outcome::stored : Outcome::refused);
    }
  } catch (const std::bad_alloc&) {  // drops the settled results, so that each is settled once
    group.erase(group.begin(), group.begin() + static_cast<std::ptrdiff_t>(settled));
    throw;
  }
  return std::nullopt;
}

// Stores the interval first: clients see it until the next worker reports.
std::optional<Error> PendingResults::give_back(const PendingResult& delivery) {
  const auto now = jobs_.time();
  if (delivery.progress) {
    const store::Beat beat{token_of(delivery), delivery.progress};
    const auto heard = jobs_.heartbeats({&beat, 1}, now + std::chrono::seconds(60));
    if (!heard) return heard.error();
  }
  const auto state = jobs_.hand_back(token_of(delivery), delivery.blame, {now, now + settings_.keep});
  if (!state) return state.error();
  settle(delivery, *state ? Outcome::stored : Outcome::refused);
  return std::nullopt;
}

// Stores the results one by one, so that one which the store does not take blocks no other. That job is handed back,
// which counts as a failure, so it ends after some tries. Returns the last error, after which some of the group stays.
std::optional<Error> PendingResults::one_by_one(Group& group) {
  std::optional<Error> last;
  std::size_t left = 0;  // results that the store did not take
  while (left < group.size()) {
    Group single;
    single.push_back(group[left]);
    auto error = single.front().ending ? store_endings(single) : give_back(single.front());
    if (error && !may_pass(*error) && single.front().ending) {
      PendingResult back{single.front().job, std::nullopt, std::nullopt,
                         "its end could not be stored: " + error->message};
      error = give_back(back);
    }
    if (error && may_pass(*error)) return error;
    if (error) {
      last = std::move(error);
      ++left;
    } else {
      group.erase(group.begin() + static_cast<std::ptrdiff_t>(left));
    }
  }
  return last;
}

void PendingResults::settle(const PendingResult& delivery, Outcome outcome) {
  listener_.delivered(delivery, outcome);
  const std::lock_guard lock(mutex_);
  --unsettled_;
  unsettled_bytes_ -= bytes_of(delivery);
  if (unsettled_ == 0) emptied_.notify_all();
}

}  // namespace meshgauge::server
