// Makes the pictures of a run while it goes on.
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

// Makes pictures on its own thread as gates end, so that a gate's meshes can be freed before the last gate ends.
// add(), end() and the destructor belong to one thread; wait_for_room() may be called by any.
class Gallery {
 public:
  // `meshes` must have a turn for the gallery. `threads` (at least 1) is for one picture after the last gate; before
  // that the processors belong to the gates, which have deadlines, and a picture takes one thread.
  Gallery(std::shared_ptr<Meshes> meshes, unsigned threads);
  Gallery(const Gallery&) = delete;
  Gallery& operator=(const Gallery&) = delete;
  ~Gallery();  // finishes the current picture and leaves out the rest

  // A gate that waits for its picture keeps its meshes in memory. So wait_for_room() blocks while more than
  // kMostWaiting gates wait, or until `control` says to stop.
  static constexpr std::size_t kMostWaiting = 2;
  void wait_for_room(Control& control);

  void add(const GateOutcome& outcome);

  // Maximum number of gates with pictures, so that a report of ten thousand gates still opens: first failed gates,
  // then undecided ones, then those nearest to their limits, whatever the order in which they end.
  static constexpr std::size_t kMostPictures = 100;

  // Waits for all pictures and returns them in the order of the outcomes. Precondition: each outcome was added. Once
  // the run is `interrupted`, unfinished pictures are left out.
  std::vector<GatePicture> end(const Report& report, const Interrupted& interrupted);

 private:
  // Order of need: smaller needs a picture more.
  struct Need {
    Verdict verdict;
    double share;  // share of the limit
    std::string name;
    bool operator<(const Need& other) const;
  };

  static Need need_of(const GateOutcome& outcome);
  void work();
  bool is_needed(const Need& need) const;
  void keep(const Need& need, GatePicture picture);

  const std::shared_ptr<Meshes> meshes_;
  const unsigned threads_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::deque<GateOutcome> waiting_;
  std::map<std::string, GatePicture> made_;  // by the gate's name
  std::set<Need> kept_;                      // those in made_ that are pictures
  bool ending_ = false;
  bool done_ = false;
  Control control_;
  std::thread worker_;  // last member: it uses all members above
};

}  // namespace meshgauge::check
