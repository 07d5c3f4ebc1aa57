// Makes the pictures of a run.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "check/html/picture.h"
#include "check/outcome.h"
#include "check/run/meshes.h"
#include "engine/control.h"

namespace meshgauge::check {

// Pictures of a gate are made by the thread that measured it, while its meshes are in memory: so all processors make
// them, and as many gates have their meshes in memory as are measured at the same time. Those of gates that pass are
// made at the end, since only then is it known which they are. draw() is thread safe, end() follows the last call.
class Gallery {
 public:
  // `meshes` must have a turn for the gallery. `gates`: all of the run. `for_report`: the HTML report has pictures;
  // else there are strips alone.
  Gallery(std::shared_ptr<Meshes> meshes, std::size_t gates, bool for_report);

  // Maximum number of gates with pictures and tables, so that a report of ten thousand gates still opens: first failed
  // gates, then undecided ones, then those nearest to their limits, whatever the order in which they end. Of the gates
  // that pass at most kMostPassing have pictures.
  static constexpr std::size_t kMostPictures = 100;
  static constexpr std::size_t kMostPassing = 12;

  // A strip, or why there is none; both are empty where none was asked for or the gate was not measured, and when
  // `control` is cancelled.
  struct Strip {
    std::vector<std::byte> png;
    std::string missing;
  };
  // Makes what the report needs of the gate, and a strip if `strip`, on `threads`. Ends the gallery's turn of its
  // meshes.
  Strip draw(const GateOutcome& outcome, bool strip, unsigned threads, Control& control);

  // Order of need: smaller needs a picture more.
  struct Need {
    Verdict verdict;
    double share;  // share of the limit
    std::string name;
    bool operator<(const Need& other) const;
  };
  static Need need_of(const GateOutcome& outcome);  // precondition: it is measured

  using Told = std::function<void(std::size_t done, std::size_t all)>;  // of the pictures that end() makes
  // Makes the pictures of gates that pass, which reads their files again, as many at a time as there are `threads`, and
  // returns all in the order of the outcomes; without a report none. `told`: called at the beginning and when one is
  // made. Once the run is `interrupted`, unfinished pictures are left out.
  std::vector<GatePicture> end(const Report& report, unsigned threads, const Interrupted& interrupted,
                               const Told& told = {});

 private:
  using Outcomes = std::vector<const GateOutcome*>;

  bool is_needed_now(const Need& need);
  void keep(const Need& need, GatePicture picture);
  Outcomes undrawn(const Report& report) const;
  void draw_together(std::span<const GateOutcome* const> some, unsigned threads, const Interrupted& interrupted,
                     const Told& told);
  void draw_each(std::span<const GateOutcome* const> some, unsigned threads, Control& control);

  const std::shared_ptr<Meshes> meshes_;
  const std::size_t gates_;
  const bool for_report_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::map<std::string, GatePicture> made_;  // by the gate's name
  std::set<Need> kept_;                      // those in made_ that are pictures
  std::size_t drawn_ = 0;                    // by end()
};

}  // namespace meshgauge::check
