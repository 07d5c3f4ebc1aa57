// The pictures of a run, made while it goes on.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "check/html/picture.h"
#include "check/outcome.h"
#include "check/run/meshes.h"
#include "engine/control.h"

namespace meshgauge::check {

// Makes them on a thread of its own, gate by gate as they end, so that the meshes of a gate can go before the last gate
// has come. add(), end() and the destructor belong to one thread; wait_for_room() may be called by any.
class Gallery {
 public:
  // `meshes` must have been told of a turn for it. `threads` >= 1 of one picture when the last gate has ended: until
  // then the processors are the gates', which have a deadline, and it takes one.
  Gallery(std::shared_ptr<Meshes> meshes, unsigned threads);
  Gallery(const Gallery&) = delete;
  Gallery& operator=(const Gallery&) = delete;
  ~Gallery();  // what is being made is finished, the rest is left out

  // What waits for its picture keeps its meshes: who measures faster than pictures are made waits here before the next
  // gate, until at most kMostWaiting do, or `control` says to stop.
  static constexpr std::size_t kMostWaiting = 2;
  void wait_for_room(Control& control);

  void add(const GateOutcome& outcome);

  // Of how many gates there are pictures, so that a report of ten thousand still opens: those that failed, then the
  // undecided, then those that come nearest to their limits. The same whatever the order in which they end.
  static constexpr std::size_t kMostPictures = 100;

  // Waits for all of them, in the order of the outcomes, each of which was added. When the run was `interrupted`, or it
  // says so meanwhile, those that are not done are left out.
  std::vector<GatePicture> end(const Report& report, const Interrupted& interrupted);

 private:
  // Smaller: needs a picture more.
  struct Need {
    Verdict verdict;
    double share;  // of the limit
    std::string name;
    bool operator<(const Need& other) const;
  };

  static Need need_of(const GateOutcome& outcome);
  void work();
  bool is_needed(const Need& need) const;
  void keep(const Need& need, GatePicture picture);

  const std::shared_ptr<Meshes> meshes_;
  const unsigned threads_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::deque<GateOutcome> waiting_;
  std::map<std::string, GatePicture> made_;  // by the gate's name
  std::set<Need> kept_;                      // of those that are pictures
  bool ending_ = false;
  bool done_ = false;
  Control control_;
  std::thread worker_;  // the last: it uses all of the above
};

}  // namespace meshgauge::check
