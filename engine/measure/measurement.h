// One measurement from its options to its outcome: runs the stages and answers the search's questions between them.
//
//   build        build_stage.h: frame, front, orders, trees
//   traverse     sweep.h, or traversal.h with a strategy of the paper
//   reduce       bisection.h, or reduction.h with a strategy of the paper
//   certify      certify.h
//   regions      region_stage.h, instead of the above, which it runs for each part
//   areas        area_stage.h: also the sides
//   statistics   statistics_stage.h
#pragma once

#include <functional>
#include <optional>

#include "engine/control.h"
#include "engine/kernels/kernels.h"
#include "engine/options.h"
#include "engine/outcome.h"
#include "engine/search/certify.h"
#include "engine/search/measured_pair.h"
#include "engine/search/search.h"
#include "engine/thread_pool.h"

namespace meshgauge {

// Wall time of a stage: adds its lifetime in milliseconds to `total_ms`.
class StageClock {
 public:
  explicit StageClock(double& total_ms) : total_ms_(total_ms) {}
  StageClock(const StageClock&) = delete;
  StageClock& operator=(const StageClock&) = delete;
  ~StageClock() { total_ms_ += ms_since(start_); }

 private:
  double& total_ms_;
  Control::Clock::time_point start_ = Control::Clock::now();
};

// Made and run once, on one thread. `options` and `control` must outlive it. Preconditions: those of measure().
class Measurement final : public Monitor {
 public:
  Measurement(const Prepared& a, const Prepared& b, const Options& options, Control& control);

  Outcome run();

  std::optional<Stop> pulse(const Search& search) override;
  bool interrupted() override { return control_.check() != Interruption::none; }

 private:
  bool is_auto() const { return options_.strategy == Strategy::automatic; }
  void set_goal();
  bool measures_points() const;
  void set_gate(double limit);
  void open(std::optional<Directed>& directed, MeasuredMesh& from, MeasuredMesh& to);
  void search_whole();
  std::optional<Stop> search_all();
  std::optional<Stop> build_both();
  std::optional<Stop> measure(MeasuredDirection& direction);
  Slack slack() const;
  void set_up(Search& search, MeasuredDirection& direction);
  std::optional<Stop> search_auto(Search& search, const OrderedMesh& from, const OrderedMesh& to);
  std::optional<Stop> search_paper(Search& search, const Bvh& from_tree);
  static void keep_bounds(const Search& search, const OrderedMesh& from, const LargeArray<float>& bounds,
                          MeasuredDirection& direction);
  void certify(const Search& search, Directed& directed, const OrderedMesh& from, const OrderedMesh& to);
  Bounds certified(const Search& search);
  bool fails_gate(const Search& search);
  void look(const Search& search);
  void report(const Search& search);
  void conclude(std::optional<Stop> stop);
  std::optional<Stop> search_anew();
  void narrow();
  std::function<void()> teller();
  void bound_areas();
  void sample();

  template <class Work>
  std::optional<Stop> staged(const char* name, double& total_ms, Work&& work);

  const Options& options_;
  Control& control_;
  const Kernels* kernels_;
  ThreadPool pool_;
  MeasuredPair pair_;
  Goal goal_;
  std::optional<double> limit_;  // at which the gate is decided now, in the meshes' unit
  Outcome outcome_;
  Directed* running_ = nullptr;  // the direction that is being searched
  const char* stage_ = "";
  double lower_ = 0;        // largest computed distance of the directions done; frame units
  double lower_slack_ = 0;  // what certifying takes from lower_
  double floor_ = 0;        // Outcome::precision_floor in frame units
  Certifier certifier_;
  std::optional<Control::Clock::time_point> interrupted_at_;      // first seen while certifying
  Control::Clock::time_point looked_at_ = Control::Clock::now();  // end of the last look(), or the start
  Control::Clock::duration look_took_{0};
  double gate_checked_at_ = -1;  // computed lower bound at the last check of the gate
  bool gate_failed_ = false;     // what that check found
};

}  // namespace meshgauge
