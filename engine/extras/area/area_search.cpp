#include "engine/extras/area/area_search.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <new>
#include <utility>

#include "engine/extras/area/places.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/search/conclusion.h"

namespace meshgauge {
namespace {

constexpr std::size_t kVerticesATask = 256;
constexpr std::size_t kTasksAGrowth = 256;  // of vertices, for which memory is touched at once
constexpr std::size_t kTrianglesATask = 64;
constexpr std::size_t kForeseenATask = 16;
constexpr std::size_t kTasksABatch = 64;  // of triangles, between two steps that keep what was found
constexpr double kClosedShare = 0.25;     // of a tolerance that the parts which are closed may add up to
constexpr double kCellShare = 1.0 / 64;   // of a tolerance that the errors of cells may add up to
constexpr double kNegligible = 0x1p-50;   // of the area, a part of which is closed
constexpr double kForeseenShare = 0.93;   // of the tolerances, for the sample
constexpr double kFactor = 1.5;           // between two attempts to refine the sample
constexpr int kMostAttempts = 12;
constexpr std::uint64_t kSampleShare = 32;  // of the work items: what one attempt may take
constexpr double kEarly = 0.5;              // of the least contribution that is refined: what is less is closed
constexpr std::size_t kOpenShare = 4;       // the other parts, while they take no more than this part of the memory
constexpr double kMostEarly = 0.25;         // of the tolerances, that what is closed early may be to blame for
constexpr std::size_t kSums = 16;           // while foresight refines all triangles, for an interruption
constexpr double kApart = 1.0 / 8;          // of its longest edge: a triangle is farther than that from B
constexpr double kResolution = 1.0 / 64;    // of a quantile's tolerance, to which its ends are sought

AreaInterval intersection(const AreaInterval& a, const AreaInterval& b) {
  return {std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
}

// Whether the corners are far from B beside their distances from each other.
bool is_apart(const std::array<Corner, 3>& corners) {
  const auto& [a, b, c] = corners;
  const double nearest = std::min({a.distance, b.distance, c.distance});
  const double size =
      std::max({squared_norm(a.point - b.point), squared_norm(b.point - c.point), squared_norm(c.point - a.point)});
  return nearest * nearest > kApart * kApart * size;
}

bool is_decided(const AreaOptions::Beyond& beyond, const AreaInterval& share) {
  return beyond.max_share && (share.upper <= *beyond.max_share || share.lower > *beyond.max_share);
}

}  // namespace

// A task starts without a hint, so that the distances do not depend on the threads.
bool measure_vertices(const AreaDirection& direction, const std::optional<std::vector<std::uint32_t>>& rest,
                      LargeArray<Corner>& corners) {
  const Interrupted stop = [&direction] { return direction.control.check() != Interruption::none; };
  const std::size_t count = direction.from.positions.size();
  std::vector<bool> used(count, !rest);
  const bool is_whole = each_unless(stop, rest ? rest->size() : 0, [&](std::size_t i) {
    for (const std::uint32_t v : direction.from.triangles[(*rest)[i]]) used[v] = true;
  });
  if (!is_whole) return false;
  corners.reserve(count);
  std::atomic<bool> stopped{false};
  for (std::size_t begin = 0; begin < count && !stopped; begin = corners.size()) {
    corners.resize(std::min(count, begin + kTasksAGrowth * kVerticesATask));
    direction.pool.run(tasks_for(corners.size() - begin, kVerticesATask), [&](std::size_t, std::size_t task) {
      if (stopped || stop()) stopped = true;
      Work work;
      std::uint32_t hint = Nearest::kNone;
      const std::size_t first = begin + task * kVerticesATask;
      for (std::size_t v = first; v < std::min(corners.size(), first + kVerticesATask) && !stopped; ++v) {
        if (!used[v]) continue;
        corners[v] = nearest_corner(direction.to, direction.from.positions[v], work, &stop, hint);
        hint = corners[v].slot;
        if (!corners[v].complete) stopped = true;
      }
    });
  }
  return !stopped;
}

AreaSearch::AreaSearch(const AreaDirection& direction)
    : in_(direction),
      asked_(*direction.options.areas),
      weights_(direction.from, direction.error),
      stop_([this] { return in_.control.check() != Interruption::none; }),
      closed_shares_(asked_.beyond.size()) {
  const int exponent = in_.frame.exponent();
  for (const auto& beyond : asked_.beyond) {
    limits_.push_back(
        {rounding::scale_down(beyond.distance, -exponent), rounding::scale_up(beyond.distance, -exponent)});
    known_.beyond.push_back({0, beyond.distance >= in_.upper ? 0.0 : 1.0});
  }
  double tolerance = asked_.mean || !asked_.quantiles.empty() ? asked_.length_tolerance * AreaOptions::kLeastLength : 1;
  for (std::size_t k = 0; k < limits_.size(); ++k) tolerance = std::min(tolerance, tolerance_of_share(k));
  const double cell_tolerance = kCellShare * tolerance;
  std::vector<double> within;
  if (are_shares_alone()) {
    for (const Limit& limit : limits_) within.push_back(limit.down);
    std::sort(within.begin(), within.end());
  }
  for (std::size_t i = 0; i < in_.pool.size(); ++i)
    bounders_.emplace_back(in_.to, in_.adjacency, in_.error, within, cell_tolerance);
  known_.quantiles.assign(asked_.quantiles.size(), {0, in_.most});
  if (asked_.mean) known_.mean = known_.rms = AreaInterval{0, in_.most};
}

AreaBounds AreaSearch::run() {
  if (demand().met()) return result(AreaStop::complete);
  try {
    return result(narrow());
  } catch (const std::bad_alloc&) {
    return result(AreaStop::budget);
  }
}

AreaStop AreaSearch::narrow() {
  if (!weigh()) return interrupted();
  if (area_.none()) return AreaStop::no_area;
  if (in_.from.positions.size() > in_.options.max_memory_bytes / sizeof(Corner)) return AreaStop::budget;
  if (!leave_out_decided() || !measure_vertices(in_, rest_, corners_) || !foresee()) return interrupted();
  AreaStop stop = bound_and_refine();
  // With foresight the floor may be that of what was closed early.
  while (stop == AreaStop::precision_floor && foresight_) {
    forget();
    stop = bound_and_refine();
  }
  if (stop == AreaStop::complete && in_.options.narrow) narrow_decided();
  return stop;
}

AreaStop AreaSearch::bound_and_refine() {
  const std::optional<AreaStop> ended = bound_triangles();
  if (ended && *ended != AreaStop::budget) return *ended;
  if (ended) return update() ? *ended : interrupted();
  return refine_all();
}

// Searches a sample of the triangles. What is worth refining there is worth it everywhere: then the triangles are
// refined one by one, and most of their parts need not be kept. A guess: where it is a poor one, rounds do the rest,
// or the search begins anew without it. False: interrupted.
bool AreaSearch::foresee() {
  const std::size_t count = in_.from.triangles.size(), size = in_.options.thresholds.area_sample;
  if (are_shares_alone() || size * in_.options.thresholds.area_samples > count) return true;
  Options options = in_.options;
  options.areas->length_tolerance *= kForeseenShare;
  options.areas->share_tolerance *= kForeseenShare;
  options.max_work_items = std::max<std::uint64_t>(1, options.max_work_items / kSampleShare);
  const AreaDirection direction{in_.from,  in_.to_mesh, in_.to,     in_.adjacency, in_.frame,   options, in_.most,
                                in_.upper, in_.error,   in_.bounds, in_.pool,      in_.control, in_.tell};
  std::vector<std::uint32_t> sample(size);
  for (std::size_t i = 0; i < size; ++i) sample[i] = static_cast<std::uint32_t>(i * count / size);
  const std::optional<Foresight> first = searched(direction, sample, std::nullopt);
  if (!first) return !stop_();
  const auto attempt = [&](double least) { return searched(direction, sample, Foresight{first->demand, least}); };
  foresight_ = attempt(first->least);
  double least = first->least;
  const bool is_enough = foresight_.has_value();
  for (int i = 0; i < kMostAttempts && !stop_(); ++i) {
    least = is_enough ? least * kFactor : least / kFactor;
    const std::optional<Foresight> found = attempt(least);
    if (found) foresight_ = found;
    if (found.has_value() != is_enough) break;
  }
  return !stop_();
}

// Searches a sample, with corners that are measured: by rounds, or by `foresight` alone. Returns what was worth
// refining. nullopt: its intervals are not narrow enough, or it needs no refining.
std::optional<AreaSearch::Foresight> AreaSearch::searched(const AreaDirection& direction,
                                                          const std::vector<std::uint32_t>& sample,
                                                          const std::optional<Foresight>& foresight) {
  AreaSearch search(direction);
  search.rest_ = sample;
  search.foresight_ = foresight;
  search.corners_.swap(corners_);
  bool is_complete = search.weigh() && !search.area_.none();
  if (is_complete && foresight) {
    is_complete = !search.bound_triangles() && search.update() && search.demand().met();
  } else if (is_complete) {
    is_complete = search.bound_and_refine() == AreaStop::complete && search.refined_ > 0;
  }
  corners_.swap(search.corners_);
  work_ += search.work_;
  if (!is_complete) return std::nullopt;
  return foresight ? foresight : Foresight{search.demand(true), search.least_chosen_};
}

// Begins anew: with more foresight if too much was closed early by what the sample showed, but not too often; else
// without, since the sample's quantiles may have been others. The intervals stay.
void AreaSearch::forget() {
  constexpr int kMostOften = 2;
  constexpr double kLess = 1.0 / 4;
  foresight_->least *= kLess;
  if (++forgotten_ > kMostOften || closed_early_ <= kMostEarly * area_.weight) foresight_.reset();
  closed_early_ = 0;
  open_.clear();
  closed_.clear();
  closed_shares_.assign(asked_.beyond.size(), {});
  closed_means_ = {};
  area_.cell_error = 0;
  area_.terms = 0;
}

// Whatever ends it, every gate is decided.
void AreaSearch::narrow_decided() {
  is_narrowing_ = true;
  if (demand().met()) return;
  const NarrowingTime time(in_.control);
  try {
    refine_all();
  } catch (const std::bad_alloc&) {  // the verdicts are known without it
  }
}

AreaStop AreaSearch::refine_all() {
  for (;;) {
    if (!update()) return interrupted();
    in_.tell();
    const Demand wanted = demand();
    if (wanted.met()) return AreaStop::complete;
    if (over_budget()) return AreaStop::budget;
    const std::vector<std::uint32_t> chosen = choose(wanted);
    if (stop_()) return interrupted();
    if (chosen.empty()) return AreaStop::precision_floor;
    if (!refine(chosen, wanted)) return interrupted();
  }
}

// False, as of the functions below: interrupted.
bool AreaSearch::weigh() {
  return each_unless(stop_, to_visit(), [&](std::size_t i) {
    const AreaWeights::Weight w = weights_.of(visited(i));
    area_.weight += w.weight;
    area_.error += w.error;
  });
}

// Shares alone need no more of a triangle that is within every limit, or beyond every one.
bool AreaSearch::leave_out_decided() {
  if (!are_shares_alone()) return true;
  double low = in_.most, high = 0;
  for (const Limit& l : limits_) low = std::min(low, l.down), high = std::max(high, l.up);
  const auto places = places_of(in_, low, high);
  if (!places) return false;
  Part within, beyond;
  within.enclosure.high = {low, low, low};
  const double above = std::nextafter(high, std::numeric_limits<double>::infinity());
  beyond.enclosure = {{above, above, above}, {in_.most, in_.most, in_.most}};
  bool any_within = false, any_beyond = false;
  std::vector<std::uint32_t> rest;
  const bool is_whole = each_unless(stop_, places->size(), [&](std::size_t t) {
    const Place place = (*places)[t];
    if (place == Place::unknown) return rest.push_back(static_cast<std::uint32_t>(t));
    (place == Place::within ? any_within : any_beyond) = true;
    (place == Place::within ? within : beyond).weight += weights_.of(t).weight;
  });
  area_.terms += places->size() - rest.size() - (any_within ? 1 : 0) - (any_beyond ? 1 : 0);  // close() counts them
  if (any_within) close(within);
  if (any_beyond) close(beyond);
  rest_ = std::move(rest);
  return is_whole;
}

// nullopt: all triangles are bounded. After `budget`, those that are left have the distance [0, most].
std::optional<AreaStop> AreaSearch::bound_triangles() {
  const std::size_t count = to_visit(), each = foresight_ ? kForeseenATask : kTrianglesATask;
  std::size_t next_sum = count / kSums + 1;
  for (std::size_t begin = 0; begin < count; begin += kTasksABatch * each) {
    if (stop_()) return interrupted();
    if (over_budget()) return close_unvisited(begin) ? AreaStop::budget : interrupted();
    if (foresight_ && begin >= next_sum) {
      if (!update_sums(begin)) return interrupted();
      in_.tell();
      next_sum = begin + count / kSums + 1;
    }
    const std::size_t end = std::min(count, begin + kTasksABatch * each);
    const std::uint64_t fit = in_.options.max_memory_bytes / 8 / sizeof(Part);
    const std::uint64_t most_parts = std::min(fit, in_.options.max_work_items - work_.subdivisions) / (end - begin);
    std::vector<Bounded> found(tasks_for(end - begin, each));
    std::atomic<bool> stopped{false};
    in_.pool.run(found.size(), [&](std::size_t worker, std::size_t task) {
      if (stopped || stop_()) stopped = true;
      const std::size_t last = stopped ? begin : std::min(end, begin + (task + 1) * each);
      for (std::size_t t = begin + task * each; t < last && !stopped; ++t) {
        if (!take_triangle(bounders_[worker], visited(t), most_parts, found[task])) stopped = true;
      }
    });
    if (stopped) return interrupted();
    for (const Bounded& one : found) take_over(one);
  }
  return std::nullopt;
}

void AreaSearch::take_over(const Bounded& found) {
  work_ += found.work;
  area_.cell_error += found.cell_error;
  for (const Part& part : found.parts) {
    if (is_closed(part)) {
      close(part);
      continue;
    }
    const double contribution = foresight_ ? foresight_->demand.contribution(part) : 0;
    const bool has_room = open_.size() * sizeof(Part) < in_.options.max_memory_bytes / kOpenShare;
    if (foresight_ && contribution < (has_room ? kEarly : 1) * foresight_->least) {
      closed_early_ += contribution;
      close(part);
    } else {
      open_.push_back(part);
    }
  }
}

// False: interrupted.
bool AreaSearch::take_triangle(PartBounder& bounder, std::size_t triangle, std::uint64_t most_parts, Bounded& found) {
  const std::array<Corner, 3> corners = corners_of(triangle);
  // Near B the overlay bounds no triangle well, and foresight tries cells at once.
  const bool by_overlay = !foresight_ || is_apart(corners);
  const Part whole = bounder.whole(corners, weights_.of(triangle).weight, by_overlay, found.work);
  if (foresight_) return refine_triangle(bounder, whole, most_parts, found);
  found.parts.push_back(whole);
  return true;
}

bool AreaSearch::close_unvisited(std::size_t begin) {
  const std::size_t count = to_visit() - begin;
  Part part;
  part.enclosure.high = {in_.most, in_.most, in_.most};
  if (!each_unless(stop_, count, [&](std::size_t t) { part.weight += weights_.of(visited(begin + t)).weight; }))
    return false;
  area_.terms += count;
  close(part);
  return true;
}

void AreaSearch::close(const Part& part) {
  ++area_.terms;
  add(part.enclosure, part.weight, closed_shares_, closed_means_);
  if (!asked_.quantiles.empty()) closed_.push_back({part.enclosure, part.weight});
}

// Whether all parts together would be within the tolerances if each were as narrow as this one.
bool AreaSearch::is_closed(const Part& part) const {
  if (part.weight <= kNegligible * area_.weight || !bounders_[0].can_narrow(part)) return true;
  const Enclosure& e = part.enclosure;
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    const double width = share_beyond(e.high, limits_[k].down) - share_beyond(e.low, limits_[k].up);
    if (width > kClosedShare * tolerance_of_share(k)) return false;
  }
  if (known_.mean && mean_width(e) > kClosedShare * tolerance_of(known_.mean->lower)) return false;
  if (known_.rms) {
    const double lower = known_.rms->lower, tolerance = tolerance_of(lower);
    if (square_width(e) > kClosedShare * tolerance * std::max(2 * lower, tolerance)) return false;
  }
  return std::all_of(known_.quantiles.begin(), known_.quantiles.end(), [&](const AreaInterval& q) {
    if (least(e.low) >= q.upper || most(e.high) <= q.lower) return true;
    double width = 0;
    for (std::size_t i = 0; i < 3; ++i) width = std::max(width, e.high[i] - e.low[i]);
    return width <= kClosedShare * tolerance_of(q.lower);
  });
}

// Adds to the sums what add(i, ShareSum, MeanSum) adds for each i below `count`: each range by itself, then the ranges
// in their order, so that any number of threads gives the same bits. False: interrupted.
template <class Add>
bool AreaSearch::add_all(std::size_t count, const Add& add, std::vector<ShareSum>& shares, MeanSum& means) {
  struct Sums {
    std::vector<ShareSum> shares;
    MeanSum means;
  };
  std::vector<Sums> sums(tasks_for(count, kPartsASum));
  const bool is_whole = each_range(stop_, count, kPartsASum, in_.pool, [&](std::size_t begin, std::size_t end) {
    Sums& sum = sums[begin / kPartsASum];
    sum.shares.resize(limits_.size());
    for (std::size_t i = begin; i < end; ++i) add(i, sum.shares, sum.means);
  });
  if (!is_whole) return false;
  for (const Sums& sum : sums) {
    for (std::size_t k = 0; k < limits_.size(); ++k) shares[k] += sum.shares[k];
    means += sum.means;
  }
  return true;
}

void AreaSearch::add(const Enclosure& enclosure, double weight, std::vector<ShareSum>& shares, MeanSum& means) const {
  for (std::size_t k = 0; k < limits_.size(); ++k) shares[k].add(enclosure, weight, limits_[k].down, limits_[k].up);
  if (asked_.mean) means.add(enclosure, weight);
}

bool AreaSearch::update() { return update_sums(to_visit()) && update_quantiles(); }

// `begin`: triangles from here on have no parts yet; what their corners show of them counts.
bool AreaSearch::update_sums(std::size_t begin) {
  std::vector<ShareSum> shares = closed_shares_;
  MeanSum means = closed_means_;
  using Shares = std::vector<ShareSum>;
  const auto add_part = [&](std::size_t i, Shares& to, MeanSum& to_means) {
    add(open_[i].enclosure, open_[i].weight, to, to_means);
  };
  const auto add_unvisited = [&](std::size_t i, Shares& to, MeanSum& to_means) {
    const std::size_t triangle = visited(begin + i);
    const Enclosure enclosure{{}, bounders_[0].high_of_corners(corners_of(triangle))};
    add(enclosure, weights_.of(triangle).weight, to, to_means);
  };
  if (!add_all(open_.size(), add_part, shares, means)) return false;
  if (!add_all(to_visit() - begin, add_unvisited, shares, means)) return false;
  const TotalArea area = area_of_all();
  for (std::size_t k = 0; k < shares.size(); ++k) {
    known_.beyond[k] = intersection(known_.beyond[k], area.share(shares[k]));
  }
  if (asked_.mean) {
    known_.mean = intersection(*known_.mean, area.mean(means, in_.most));
    known_.rms = intersection(*known_.rms, area.rms(means, in_.most));
    known_.rms->lower = std::max(known_.rms->lower, known_.mean->lower);
    known_.mean->upper = std::min(known_.mean->upper, known_.rms->upper);
  }
  return true;
}

// With the terms of all sums over parts and triangles.
TotalArea AreaSearch::area_of_all() const {
  TotalArea area = area_;
  area.terms += open_.size() + 2 * in_.from.triangles.size();
  return area;
}

bool AreaSearch::update_quantiles() {
  const TotalArea area = area_of_all();
  for (std::size_t q = 0; q < asked_.quantiles.size(); ++q) {
    AreaInterval& known = known_.quantiles[q];
    const double resolution = kResolution * tolerance_of(known.lower);
    const auto found = quantile(asked_.quantiles[q], area, {closed_, open_}, known, resolution, stop_);
    if (!found) return false;
    known = *found;
  }
  return true;
}

// The width that is narrow enough for the interval of a length with this value.
double AreaSearch::tolerance_of(double length) const {
  return asked_.length_tolerance * std::max(length, AreaOptions::kLeastLength * in_.most);
}

double AreaSearch::tolerance_of_share(std::size_t k) const {
  return asked_.beyond[k].max_share ? std::min(asked_.share_tolerance, AreaOptions::kGateTolerance)
                                    : asked_.share_tolerance;
}

// Whether a share needs no more work.
bool AreaSearch::is_narrow(std::size_t k) const {
  const AreaInterval& share = known_.beyond[k];
  const double width = share.upper - share.lower;
  if (width <= tolerance_of_share(k)) return true;
  return is_decided(asked_.beyond[k], share) && (!is_narrowing_ || width <= kNarrowRelative * share.upper);
}

Demand AreaSearch::demand(bool of_all) const {
  Demand demand;
  const auto is_asked = [&](const AreaInterval& known, double tolerance, bool is_enough) {
    if (is_enough && !of_all) return false;
    demand.excess = std::max(demand.excess, (known.upper - known.lower) / tolerance - 1);
    return true;
  };
  const auto is_length_asked = [&](const AreaInterval& known) {
    const double tolerance = tolerance_of(known.upper);
    return is_asked(known, tolerance, known.upper - known.lower <= tolerance);
  };
  for (std::size_t k = 0; k < limits_.size(); ++k) {
    const double tolerance = tolerance_of_share(k);
    if (is_asked(known_.beyond[k], tolerance, is_narrow(k)))
      demand.probes.push_back({limits_[k].down, limits_[k].up, 1 / tolerance});
  }
  for (const AreaInterval& q : known_.quantiles) {
    if (is_length_asked(q)) demand_quantile(q, demand);
  }
  if (known_.mean && is_length_asked(*known_.mean)) demand.mean = 1 / tolerance_of(known_.mean->upper);
  if (known_.rms && is_length_asked(*known_.rms)) {
    const auto& [lower, upper] = *known_.rms;
    demand.square = 1 / (tolerance_of(upper) * (upper + lower));
  }
  return demand;
}

// The widths of the shares at the ends and in the middle of the interval, scaled so that they add up to its width in
// tolerances.
void AreaSearch::demand_quantile(const AreaInterval& known, Demand& demand) const {
  const double width = known.upper - known.lower;
  const std::array at{known.lower, known.lower + width / 2, known.upper};
  double sum = 0;
  each_unless(stop_, open_.size(), [&](std::size_t i) {
    const Part& part = open_[i];
    for (const double t : at) {
      sum += part.weight * (share_beyond(part.enclosure.high, t) - share_beyond(part.enclosure.low, t));
    }
  });
  const double scale = sum > 0 ? width / tolerance_of(known.upper) * area_.weight / sum : 1;
  for (const double t : at) demand.probes.push_back({t, t, scale});
}

AreaStop AreaSearch::interrupted() const {
  return in_.control.check() == Interruption::timeout ? AreaStop::timeout : AreaStop::cancelled;
}

AreaBounds AreaSearch::result(AreaStop stop) const {
  AreaBounds found = known_;
  found.stop = stop;
  found.pieces = area_.terms + open_.size();
  const int exponent = in_.frame.exponent();
  const auto scale = [&](AreaInterval& length) {
    length = {rounding::scale_down(length.lower, exponent), rounding::scale_up(length.upper, exponent)};
  };
  for (AreaInterval& q : found.quantiles) scale(q);
  if (found.mean) scale(*found.mean);
  if (found.rms) scale(*found.rms);
  return found;
}

}  // namespace meshgauge
