#include "check/html/gallery.h"

#include <chrono>
#include <utility>

namespace meshgauge::check {
namespace {

constexpr std::chrono::milliseconds kTick{20};

}  // namespace

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

void Gallery::add(const GateOutcome& outcome) {
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(outcome);
  }
  changed_.notify_all();
}

void Gallery::wait_for_room(Control& control) {
  std::unique_lock lock(mutex_);
  while (waiting_.size() > kMostWaiting && control.check() == Interruption::none) changed_.wait_for(lock, kTick);
}

void Gallery::work() {
  Crew alone(1), all(threads_);
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) break;
    Crew& crew = ending_ ? all : alone;
    const GateOutcome outcome = std::move(waiting_.front());
    waiting_.pop_front();
    changed_.notify_all();
    lock.unlock();
    GatePicture picture = picture_of(outcome, *meshes_, crew, control_);
    lock.lock();
    made_.emplace(outcome.gate.name, std::move(picture));
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
      changed_.wait_for(lock, kTick);
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
