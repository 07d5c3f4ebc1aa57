#include "cli/mcp/calls.h"

#include <algorithm>
#include <exception>
#include <system_error>
#include <utility>

namespace meshgauge::mcp {

Calls::Calls(unsigned threads, const Most& most, Send send) : most_(most), send_(std::move(send)) {
  try {
    while (threads_.size() < threads) threads_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {  // as many as there are
  }
}

Calls::~Calls() {
  {
    const std::lock_guard lock(mutex_);
    stop();
  }
  for (std::thread& thread : threads_) thread.join();
}

Calls::Begun Calls::begin(const std::string& id, std::size_t bytes, Work work) {
  const auto call = std::make_shared<Call>();
  call->id = id;
  call->bytes = bytes;
  call->work = std::move(work);
  {
    const std::lock_guard lock(mutex_);
    if (calls_.contains(id)) return Begun::same_id;
    if (calls_.size() >= most_.calls || bytes_ + bytes > most_.bytes) return Begun::too_many;
    calls_.emplace(id, call);
    bytes_ += bytes;
    if (threads_.empty()) {
      ++running_;
    } else {
      waiting_.push_back(call);
    }
  }
  if (threads_.empty()) {
    run(*call);
  } else {
    changed_.notify_all();
  }
  return Begun::yes;
}

void Calls::cancel(const std::string& id) {
  std::shared_ptr<Call> waiting;  // freed after the lock is released
  const std::lock_guard lock(mutex_);
  const auto found = calls_.find(id);
  if (found == calls_.end()) return;
  found->second->control.cancel();
  const auto place = std::ranges::find(waiting_, found->second);
  if (place == waiting_.end()) return;
  waiting = std::move(*place);
  waiting_.erase(place);
  release(*waiting);
}

std::size_t Calls::running() const {
  const std::lock_guard lock(mutex_);
  return running_;
}

bool Calls::end(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  stop();
  return changed_.wait_for(lock, patience, [this] { return running_ == 0; });
}

void Calls::stop() {
  is_ending_ = true;
  waiting_.clear();
  for (const auto& [id, call] : calls_) call->control.cancel();
  changed_.notify_all();
}

void Calls::serve() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return is_ending_ || !waiting_.empty(); });
    if (is_ending_) return;
    const std::shared_ptr<Call> call = std::move(waiting_.front());
    waiting_.pop_front();
    ++running_;
    lock.unlock();
    run(*call);
    lock.lock();
  }
}

void Calls::run(Call& call) {
  try {
    std::string answer = call.control.cancelled() ? std::string() : call.work(call.control);
    call.work = nullptr;  // what it holds is freed before the next message is taken
    std::unique_lock lock(mutex_);
    release(call);
    const bool is_wanted = !answer.empty() && !call.control.cancelled();
    lock.unlock();
    if (is_wanted) send_(std::move(answer));
  } catch (const std::exception&) {  // there is no memory even to say so
  }
  call.work = nullptr;
  const std::lock_guard lock(mutex_);
  release(call);
  --running_;
  changed_.notify_all();
}

void Calls::release(const Call& call) {
  const auto found = calls_.find(call.id);
  if (found == calls_.end() || found->second.get() != &call) return;  // it is released already
  bytes_ -= call.bytes;
  calls_.erase(found);
}

}  // namespace meshgauge::mcp
