#include "engine/extras/area/side_search.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <new>
#include <utility>

#include "engine/extras/area/places.h"
#include "engine/extras/area/winding.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/search/conclusion.h"
#include "engine/tree/nearest.h"

namespace meshgauge {
namespace {

constexpr std::size_t kTrianglesATask = 64;
constexpr std::size_t kTasksABatch = 64;  // between two steps that keep what was found
constexpr std::size_t kPartsATask = 16;
constexpr std::size_t kFewChosen = 512;  // parts refined in one round
constexpr std::size_t kMostChosen = std::size_t{1} << 15;
constexpr std::size_t kVerticesASeed = 64;  // consecutive ones, of which the farthest is a seed
constexpr std::size_t kMostSeeds = 512;

// The maximum of `high` where low <= 0: at a corner, or where low passes 0 on an edge. 0: nowhere. R12 bounds the error
// of a quotient and a sum.
double most_where_not_above(const Linear& low, const Linear& high) {
  double found = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (low[i] > 0) continue;
    found = std::max(found, high[i]);
    for (const std::size_t j : {(i + 1) % 3, (i + 2) % 3}) {
      if (low[j] <= 0) continue;
      const double at = low[i] / (low[i] - low[j]);
      found = std::max(found, high[i] + at * (high[j] - high[i]) + rounding::kCutValueSlack);
    }
  }
  return found;
}

void limit_other_side(SidePart& part) {
  if (!part.side) return;
  double& other = part.upper[1 - *part.side];
  other = std::min(other, most_where_not_above(part.part.enclosure.low, part.part.enclosure.high));
}

}  // namespace

SideSearch::SideSearch(const AreaDirection& direction, const SideOptions& asked)
    : in_(direction), asked_(asked), stop_([this] { return in_.control.check() != Interruption::none; }) {
  for (std::size_t i = 0; i < in_.pool.size(); ++i) bounders_.emplace_back(in_.to, in_.adjacency, in_.error);
  if (!asked.limits) return;
  const int exponent = in_.frame.exponent();
  const auto limits = [&](double limit) {
    const LimitEnds ends = in_.options.ends(limit);
    return LimitEnds{rounding::scale_down(std::max(ends.pass, 0.0), -exponent),
                     rounding::scale_up(ends.fail, -exponent)};
  };
  limits_ = {limits(asked.limits->outside), limits(asked.limits->inside)};
}

SideOutcome SideSearch::run() {
  try {
    return result(search());
  } catch (const std::bad_alloc&) {
    is_covered_ = false;
    return result(AreaStop::budget);
  }
}

AreaStop SideSearch::search() {
  if (in_.most <= goal(kOutside) && in_.most <= goal(kInside)) return AreaStop::complete;
  if (in_.from.positions.size() > in_.options.max_memory_bytes / sizeof(Corner)) return AreaStop::budget;
  if (!leave_out_within() || !measure_vertices(in_, rest_, corners_)) return interrupted();
  seed();
  if (const std::optional<AreaStop> ended = bound_triangles()) return *ended;
  return refine_all();
}

// False: interrupted.
bool SideSearch::leave_out_within() {
  if (!limits_) return true;
  const double low = std::min((*limits_)[kOutside].pass, (*limits_)[kInside].pass);
  const auto places = places_of(in_, low, 2 * in_.most);
  if (!places) return false;
  std::vector<std::uint32_t> rest;
  const bool is_whole = each_unless(stop_, places->size(), [&](std::uint32_t t) {
    if ((*places)[t] != Place::within) rest.push_back(t);
  });
  if (rest.size() < places->size()) close({low, low});
  pieces_ += places->size() - rest.size();
  rest_ = std::move(rest);
  return is_whole;
}

// The farthest vertices, spread over A, whether they are on one side or on both. An interruption leaves out the rest.
void SideSearch::seed() {
  std::vector<std::uint32_t> seeds;
  for (std::size_t begin = 0; begin < corners_.size(); begin += kVerticesASeed) {
    const std::size_t end = std::min(corners_.size(), begin + kVerticesASeed);
    std::size_t farthest = begin;
    for (std::size_t v = begin; v < end; ++v) {
      if (corners_[v].distance > corners_[farthest].distance) farthest = v;
    }
    seeds.push_back(static_cast<std::uint32_t>(farthest));
  }
  const auto count = std::min(seeds.size(), kMostSeeds);
  std::partial_sort(seeds.begin(), seeds.begin() + static_cast<std::ptrdiff_t>(count), seeds.end(),
                    [&](std::uint32_t v, std::uint32_t w) {
                      return std::pair(-corners_[v].distance, v) < std::pair(-corners_[w].distance, w);
                    });
  seeds.resize(count);
  for (const std::uint32_t v : seeds) {
    if (corners_[v].slot == Nearest::kNone || stop_()) break;
    Learnt learnt;
    reach(corners_[v], bounders_[0].slack_low(0), v, learnt, work_);  // the vertex, until below
    take(learnt);
  }
  for (Reached& reached : reached_) {
    if (reached.lower == 0) continue;
    const auto holds = [v = reached.triangle](const Triangle& t) {
      return std::find(t.begin(), t.end(), v) != t.end();
    };
    reached.triangle = static_cast<std::uint32_t>(
        std::find_if(in_.from.triangles.begin(), in_.from.triangles.end(), holds) - in_.from.triangles.begin());
  }
}

// nullopt: all triangles are bounded.
std::optional<AreaStop> SideSearch::bound_triangles() {
  const std::size_t count = rest_ ? rest_->size() : in_.from.triangles.size();
  std::vector<SidePart> parts;
  for (std::size_t begin = 0; begin < count; begin += kTasksABatch * kTrianglesATask) {
    if (stop_()) return interrupted();
    if (over_budget()) return AreaStop::budget;
    const std::size_t end = std::min(count, begin + kTasksABatch * kTrianglesATask);
    parts.assign(end - begin, {});
    in_.pool.run(tasks_for(end - begin, kTrianglesATask), [&](std::size_t worker, std::size_t task) {
      Work work;
      const std::size_t last = std::min(end, begin + (task + 1) * kTrianglesATask);
      for (std::size_t i = begin + task * kTrianglesATask; i < last; ++i) {
        SidePart& part = parts[i - begin];
        part.triangle = rest_ ? (*rest_)[i] : static_cast<std::uint32_t>(i);
        const Triangle& t = in_.from.triangles[part.triangle];
        part.part = bounders_[worker].whole({corners_[t[0]], corners_[t[1]], corners_[t[2]]}, 0, true, work);
        part.upper.fill(most(part.part.enclosure.high));
      }
    });
    pieces_ += parts.size();
    for (SidePart& part : parts) keep(std::move(part));
  }
  corners_ = {};
  is_covered_ = true;
  return std::nullopt;
}

AreaStop SideSearch::refine_all() {
  for (;;) {
    in_.tell();
    if (turned_ || is_decided()) return AreaStop::complete;
    const std::vector<std::size_t> chosen = choose();
    if (open_.empty()) return at_floor_ ? AreaStop::precision_floor : AreaStop::complete;
    if (chosen.empty() || over_budget()) return AreaStop::budget;
    if (stop_() || !refine(chosen)) return interrupted();
  }
}

// Closes the parts that need no more work and returns those with the largest excess, ascending.
std::vector<std::size_t> SideSearch::choose() {
  std::erase_if(open_, [&](const SidePart& part) {
    const bool needs_more = excess(part) > 0;
    if (needs_more && !part.is_at_floor) return false;
    at_floor_ = at_floor_ || needs_more;
    close(part.upper);
    return true;
  });
  std::vector<std::pair<double, std::size_t>> by_excess;
  for (std::size_t i = 0; i < open_.size(); ++i) by_excess.emplace_back(-excess(open_[i]), i);
  const auto left =
      static_cast<std::size_t>(std::min<std::uint64_t>(kMostChosen, in_.options.max_work_items - work_.subdivisions));
  const std::size_t count = std::min({by_excess.size(), std::max(kFewChosen, open_.size() / 4), left});
  std::nth_element(by_excess.begin(), by_excess.begin() + static_cast<std::ptrdiff_t>(count), by_excess.end());
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(by_excess[i].second);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

// False: interrupted, and nothing has changed.
bool SideSearch::refine(const std::vector<std::size_t>& chosen) {
  std::vector<Refined> found(chosen.size());
  std::vector<Work> works(in_.pool.size());
  std::atomic<bool> stopped{false};
  in_.pool.run(tasks_for(chosen.size(), kPartsATask), [&](std::size_t worker, std::size_t task) {
    if (stop_()) stopped = true;
    const std::size_t end = std::min(chosen.size(), (task + 1) * kPartsATask);
    for (std::size_t i = task * kPartsATask; i < end && !stopped; ++i) {
      found[i].first = open_[chosen[i]];
      refine_one(bounders_[worker], found[i], works[worker]);
      if (found[i].learnt.stopped) stopped = true;
    }
  });
  for (const Work& work : works) work_ += work;
  if (stopped) return false;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    open_[chosen[i]] = found[i].first;
    if (found[i].is_split) open_.push_back(found[i].second), ++pieces_;
    take(found[i].learnt);
  }
  return true;
}

void SideSearch::refine_one(PartBounder& bounder, Refined& refined, Work& work) const {
  SidePart& part = refined.first;
  if (!part.part.has_low) {
    find_side(bounder, part, refined.learnt, work);
    part.part.has_low = true;
    if (refined.learnt.stopped || excess(part) <= 0) return;
  }
  if (!bounder.can_narrow(part.part)) {
    part.is_at_floor = true;
    return;
  }
  auto halves = bounder.split(part.part, work, &stop_);
  if (!halves) {
    refined.learnt.stopped = true;
    return;
  }
  refined.second = part;
  refined.is_split = true;
  part.part = (*halves)[0];
  refined.second.part = (*halves)[1];
  for (SidePart* half : {&part, &refined.second}) {
    for (double& upper : half->upper) upper = std::min(upper, most(half->part.enclosure.high));
    limit_other_side(*half);
  }
}

// Also learns the distance of the farthest corner. A lower function is at most the distances of the corners.
void SideSearch::find_side(PartBounder& bounder, SidePart& part, Learnt& learnt, Work& work) const {
  const auto& corners = part.part.corners;
  const double slack = bounder.slack_low(part.part.depth);
  const auto& farthest = *std::max_element(corners.begin(), corners.end(),
                                           [](const Corner& a, const Corner& b) { return a.distance < b.distance; });
  if (!(farthest.distance > slack)) return;
  if (!part.side || least(part.part.enclosure.low) <= 0) {
    if (!bounder.bound_below(part.part, in_.most, work, &stop_)) learnt.stopped = true;
    const Linear& low = part.part.enclosure.low;
    const auto highest = static_cast<std::size_t>(std::max_element(low.begin(), low.end()) - low.begin());
    part.side.reset();
    if (low[highest] > 0) part.side = side_of(corners[highest].point, learnt, work);
    limit_other_side(part);
  }
  reach(farthest, slack, part.triangle, learnt, work);
}

// The side of a point whose exact image is not on B, nor anything between both. nullopt: unknown.
std::optional<std::size_t> SideSearch::side_of(const Vec3& point, Learnt& learnt, Work& work) const {
  const auto winding = winding_number(in_.to, point, work, &stop_);
  if (!winding) return std::nullopt;
  if (*winding < 0) learnt.turned = point;
  return *winding < 0 ? std::nullopt : std::optional(*winding > 0 ? kInside : kOutside);
}

// Where the corner is farther than any point known on its side, learns that. `slack`: how far the exact point may be
// from it. A certified distance above that shows that the exact point is on the side of the corner.
void SideSearch::reach(const Corner& corner, double slack, std::uint32_t triangle, Learnt& learnt, Work& work) const {
  const double known = std::min(reached_[kOutside].lower, reached_[kInside].lower);
  if (corner.distance - slack <= known) return;
  Learnt here;
  const auto side = side_of(corner.point, here, work);
  if (!side && !here.turned) return;
  if (side && corner.distance - slack <= reached_[*side].lower) return;
  const auto below = certified_distance_below(in_.to, corner.point, &stop_);
  if (!below) {
    learnt.stopped = true;
    return;
  }
  const double lower = rounding::subtract_down(*below, slack);
  if (lower > 0 && here.turned) learnt.turned = here.turned;
  if (side && lower > reached_[*side].lower) learnt.reached[*side] = Reached{lower, corner.point, triangle};
}

void SideSearch::take(const Learnt& learnt) {
  if (!turned_) turned_ = learnt.turned;
  for (std::size_t side = 0; side < 2; ++side) {
    const auto& found = learnt.reached[side];
    if (found && found->lower > reached_[side].lower) reached_[side] = *found;
  }
}

// Whether one limit is surely exceeded.
bool SideSearch::is_decided() const {
  return limits_ &&
         (reached_[kOutside].lower > (*limits_)[kOutside].fail || reached_[kInside].lower > (*limits_)[kInside].fail);
}

// What a part on this side may reach without more work.
double SideSearch::goal(std::size_t side) const {
  const double lower = reached_[side].lower;
  if (!limits_) return lower + asked_.length_tolerance * std::max(lower, SideOptions::kLeastLength * in_.most);
  const bool may_pass =
      reached_[kOutside].lower <= (*limits_)[kOutside].pass && reached_[kInside].lower <= (*limits_)[kInside].pass;
  const LimitEnds& limits = (*limits_)[side];
  return std::max(may_pass ? limits.pass : limits.fail, lower + SideOptions::kGateTolerance * in_.most);
}

// By how much it may exceed what is asked; <= 0: it needs no more work.
double SideSearch::excess(const SidePart& part) const {
  return std::max(part.upper[kOutside] - goal(kOutside), part.upper[kInside] - goal(kInside));
}

void SideSearch::close(const std::array<double, 2>& upper) {
  for (const std::size_t side : {kOutside, kInside}) closed_[side] = std::max(closed_[side], upper[side]);
}

void SideSearch::keep(SidePart&& part) { excess(part) > 0 ? open_.push_back(std::move(part)) : close(part.upper); }

bool SideSearch::over_budget() const {
  constexpr std::size_t kNotes = 40;  // those of choose(), and for the blocks of a deque
  const std::size_t refined = std::min(open_.size(), kMostChosen) * sizeof(Refined);
  return bytes_of(corners_) + open_.size() * (sizeof(SidePart) + kNotes) + refined > in_.options.max_memory_bytes ||
         work_.subdivisions >= in_.options.max_work_items;
}

AreaStop SideSearch::interrupted() const {
  return in_.control.check() == Interruption::timeout ? AreaStop::timeout : AreaStop::cancelled;
}

SideOutcome SideSearch::result(AreaStop stop) const {
  SideOutcome found;
  found.options = asked_;
  found.stop = stop;
  found.pieces = pieces_;
  if (turned_) found.refused = NoSides{NoSides::Why::part_inside_out, in_.frame.from_frame(*turned_)};
  std::array<double, 2> upper = is_covered_ ? closed_ : std::array{in_.most, in_.most};
  for (const SidePart& part : open_) {
    for (const std::size_t side : {kOutside, kInside}) upper[side] = std::max(upper[side], part.upper[side]);
  }
  const int exponent = in_.frame.exponent();
  for (const std::size_t side : {kOutside, kInside}) {
    const Reached& reached = reached_[side];
    SideBounds& bounds = side == kOutside ? found.outside : found.inside;
    bounds.lower = rounding::scale_down(reached.lower, exponent);
    bounds.upper = std::min(rounding::scale_up(std::min(upper[side], in_.most), exponent), in_.upper);
    if (reached.lower == 0) continue;
    bounds.at = in_.frame.from_frame(reached.at);
    bounds.triangle = in_.from.original[reached.triangle];
  }
  return found;
}

SideOutcome search_sides(const AreaDirection& direction, const SideOptions& asked) {
  SideOutcome found = SideSearch(direction, asked).run();
  if (!asked.limits || !direction.options.narrow || found.stop != AreaStop::complete || found.refused) return found;
  const NarrowingTime time(direction.control);
  SideOptions plain = asked;
  plain.limits.reset();
  plain.length_tolerance = std::max(plain.length_tolerance, kNarrowRelative);
  const SideOutcome narrow = SideSearch(direction, plain).run();
  for (const auto side : {&SideOutcome::outside, &SideOutcome::inside}) {
    const double upper = std::min((found.*side).upper, (narrow.*side).upper);
    if (!narrow.refused && (narrow.*side).lower > (found.*side).lower) found.*side = narrow.*side;
    if (!narrow.refused) (found.*side).upper = upper;
  }
  return found;
}

}  // namespace meshgauge
