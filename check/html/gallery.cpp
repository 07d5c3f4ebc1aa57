#include "check/html/gallery.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <iterator>
#include <limits>
#include <thread>
#include <utility>

#include "engine/thread_pool.h"

namespace meshgauge::check {
namespace {

constexpr std::chrono::milliseconds kPictureTick{20};

GatePicture left_out() {
  GatePicture none;
  none.left_out = true;
  return none;
}

GatePicture undrawn_because(const std::string& why) {
  GatePicture none;
  none.missing = why;
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

Gallery::Gallery(std::shared_ptr<Meshes> meshes, std::size_t gates, bool for_report)
    : meshes_(std::move(meshes)), gates_(gates), for_report_(for_report) {}

Gallery::Need Gallery::need_of(const GateOutcome& outcome) {
  const Criterion& criterion = outcome.measured->foremost();
  const double share = criterion.upper / std::max(criterion.limit, std::numeric_limits<double>::min());
  return {outcome.verdict(), share, outcome.gate.name};
}

bool Gallery::is_needed_now(const Need& need) {
  if (!for_report_ || (need.verdict == Verdict::pass && gates_ > kMostPassing)) return false;
  const std::lock_guard lock(mutex_);
  const bool is_needed = kept_.size() < kMostPictures || need < *kept_.rbegin();
  if (!is_needed) made_.emplace(need.name, left_out());
  return is_needed;
}

void Gallery::keep(const Need& need, GatePicture picture) {
  const std::lock_guard lock(mutex_);
  if (!picture.surfaces.empty()) kept_.insert(need);
  made_.emplace(need.name, std::move(picture));
  if (kept_.size() <= kMostPictures) return;
  made_.at(kept_.rbegin()->name) = left_out();
  kept_.erase(std::prev(kept_.end()));
}

Gallery::Strip Gallery::draw(const GateOutcome& outcome, bool strip, unsigned threads, Control& control) {
  const bool is_measured = outcome.measured.has_value() && !control.cancelled();
  const Drawn drawn{is_measured && is_needed_now(need_of(outcome)), is_measured && strip};
  if (!drawn.surfaces && !drawn.strip) {
    meshes_->done(outcome.gate);
    return {};
  }
  ThreadPool pool(threads);
  GatePicture picture = picture_of(outcome, *meshes_, pool, control, drawn);
  Strip made{std::move(picture.strip), drawn.strip && !control.cancelled() ? picture.missing : ""};
  if (drawn.surfaces) keep(need_of(outcome), std::move(picture));
  return made;
}

// The gates that have been measured and have no picture yet; what needs one most comes first.
Gallery::Outcomes Gallery::undrawn(const Report& report) const {
  std::vector<std::pair<Need, const GateOutcome*>> needs;
  for (const GateOutcome& outcome : report.outcomes) {
    if (outcome.measured && !made_.contains(outcome.gate.name)) needs.emplace_back(need_of(outcome), &outcome);
  }
  std::ranges::sort(needs, [](const auto& a, const auto& b) { return a.first < b.first; });
  Outcomes outcomes;
  for (const auto& [need, outcome] : needs) outcomes.push_back(outcome);
  return outcomes;
}

void Gallery::draw_each(std::span<const GateOutcome* const> some, unsigned threads, Control& control) {
  const std::size_t together = std::min<std::size_t>(std::max(threads, 1U), some.size());
  ThreadPool gates(together);
  gates.run(some.size(), [&](std::size_t, std::size_t i) {
    const GateOutcome& outcome = *some[i];
    if (!control.cancelled()) {
      ThreadPool pool(std::max<std::size_t>(1, threads / together));
      meshes_->again(outcome.gate);
      keep(need_of(outcome), picture_of(outcome, *meshes_, pool, control));
    }
    const std::lock_guard lock(mutex_);
    ++drawn_;
    changed_.notify_all();
  });
}

// The caller's thread looks after interruptions.
void Gallery::draw_together(std::span<const GateOutcome* const> some, unsigned threads, const Interrupted& interrupted,
                            const Told& told) {
  if (some.empty()) return;
  Control control;
  bool done = false;
  std::thread drawing([&] {
    try {
      draw_each(some, threads, control);
    } catch (const std::exception&) {  // end() says which pictures are missing
    }
    const std::lock_guard lock(mutex_);
    done = true;
    changed_.notify_all();
  });
  {
    std::unique_lock lock(mutex_);
    for (std::size_t shown = some.size(); !done; changed_.wait_for(lock, kPictureTick)) {
      if (interrupted()) control.cancel();
      if (told && shown != drawn_) told(shown = drawn_, some.size());
    }
  }
  drawing.join();
}

std::vector<GatePicture> Gallery::end(const Report& report, unsigned threads, const Interrupted& interrupted,
                                      const Told& told) {
  if (!for_report_) return {};
  const Outcomes waiting = report.interrupted ? Outcomes() : undrawn(report);
  const std::size_t room = std::min(kMostPictures - std::min(kept_.size(), kMostPictures), waiting.size());
  const std::size_t drawn = std::min(room, kMostPassing);
  draw_together(std::span(waiting).first(drawn), threads, interrupted, told);
  for (std::size_t i = drawn; i < waiting.size(); ++i) {
    made_.emplace(waiting[i]->gate.name,
                  i < room ? undrawn_because("of the gates that pass, those " + std::to_string(kMostPassing) +
                                             " have one that come nearest to their limits")
                           : left_out());
  }
  const std::string why = report.interrupted || interrupted() ? "the run was interrupted" : "it could not be made";
  std::vector<GatePicture> pictures;
  for (const GateOutcome& outcome : report.outcomes) {
    const auto made = made_.find(outcome.gate.name);
    const bool is_made = made != made_.end();
    pictures.push_back(is_made ? std::move(made->second) : undrawn_because(outcome.measured ? why : ""));
  }
  return pictures;
}

}  // namespace meshgauge::check
