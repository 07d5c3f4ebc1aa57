#include "check/html/gallery.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <limits>
#include <utility>

namespace meshgauge::check {
namespace {

constexpr std::chrono::milliseconds kPictureTick{20};

GatePicture left_out() {
  GatePicture none;
  none.left_out = true;
  return none;
}

int rank(Verdict verdict) {
  if (verdict == Verdict::fail) return 0;
  return verdict == Verdict::undecided ? 1 : 2;
}

}  // namespace

bool Gallery::Need::operator<(const Need& other) const {
  const std::pair mine(rank(verdict), -share), theirs(rank(other.verdict), -other.share);
  return mine != theirs ? mine < theirs : name < other.name;
}

bool Gallery::is_needed(const Need& need) const { return kept_.size() < kMostPictures || need < *kept_.rbegin(); }

void Gallery::keep(const Need& need, GatePicture picture) {
  if (!picture.surfaces.empty()) kept_.insert(need);
  made_.emplace(need.name, std::move(picture));
  if (kept_.size() <= kMostPictures) return;
  made_.at(kept_.rbegin()->name) = left_out();
  kept_.erase(std::prev(kept_.end()));
}

Gallery::Gallery(std::shared_ptr<Meshes> meshes, unsigned threads)
    : meshes_(std::move(meshes)), threads_(threads), worker_([this] { work(); }) {}

Gallery::~Gallery() {
  {
    const std::lock_guard lock(mutex_);
    waiting_.clear();
    ending_ = true;
  }
  control_.cancel();
  changed_.notify_all();
  if (worker_.joinable()) worker_.join();
}

Gallery::Need Gallery::need_of(const GateOutcome& outcome) {
  if (!outcome.measured) return {Verdict::error, 0, outcome.gate.name};
  const Criterion& criterion = outcome.measured->foremost();
  const double share = criterion.upper / std::max(criterion.limit, std::numeric_limits<double>::min());
  return {outcome.measured->verdict, share, outcome.gate.name};
}

void Gallery::add(const GateOutcome& outcome) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(outcome);
  }
  changed_.notify_all();
}

void Gallery::wait_for_room(Control& control) {
  std::unique_lock lock(mutex_);
  while (waiting_.size() > kMostWaiting && control.check() == Interruption::none) changed_.wait_for(lock, kPictureTick);
}

void Gallery::work() {
  ThreadPool alone(1), all(threads_);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) break;
    ThreadPool& pool = ending_ ? all : alone;
    const GateOutcome outcome = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    const Need need = need_of(outcome);
    const bool needed = !outcome.measured || is_needed(need);
    lock.unlock();
    GatePicture picture = needed ? picture_of(outcome, *meshes_, pool, control_) : left_out();
    if (!needed) meshes_->done(outcome.gate);
    lock.lock();
    keep(need, std::move(picture));
  }
  done_ = true;
  changed_.notify_all();
}

std::vector<GatePicture> Gallery::end(const Report& report, const Interrupted& interrupted) {
  {
    std::unique_lock lock(mutex_);
    ending_ = true;
    changed_.notify_all();
    while (!done_) {
      if (report.interrupted || interrupted()) {
        waiting_.clear();
        control_.cancel();
      }
      changed_.wait_for(lock, kPictureTick);
    }
  }
  worker_.join();
  std::vector<GatePicture> pictures;
  for (const GateOutcome& outcome : report.outcomes) {
    const auto made = made_.find(outcome.gate.name);
    pictures.push_back(made != made_.end() ? std::move(made->second) : GatePicture{{}, "the run was interrupted"});
  }
  return pictures;
}

}  // namespace meshgauge::check
