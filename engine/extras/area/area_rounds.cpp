// Rounds of the area search: which parts are refined, and how.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/extras/area/area_search.h"
#include "engine/mesh/mesh_index.h"

namespace meshgauge {
namespace {

constexpr std::size_t kPartsATask = 16;
constexpr std::size_t kMostChosen = std::size_t{1} << 13;  // parts refined in one round
constexpr std::size_t kMostMade = 32;                      // parts that mostly come of one
constexpr double kChosenShare = 0.6;                       // of all contributions, refined in one round
constexpr double kLeastChosenShare = 0.05;
constexpr double kGain = 0.5;                // of the contribution of a part, which refining it mostly removes
constexpr std::size_t kMostOfTriangle = 64;  // parts that a triangle is refined to by foresight

// Returns 2^(quarters / 4), rounded to nearest. Not std::exp2, whose last digit differs from library to library.
double power_of_quarters(int quarters) {
  constexpr std::array<double, 4> kPowers{1, 0x1.306fe0a31b715p0, 0x1.6a09e667f3bcdp0, 0x1.ae89f995ad3adp0};
  const int whole = quarters >> 2;  // towards -infinity
  return std::ldexp(kPowers[static_cast<std::size_t>(quarters - 4 * whole)], whole);
}

}  // namespace

// What comes of a part.
struct AreaSearch::Refined {
  static constexpr std::size_t kBytes = sizeof(Part) + 64 + kMostMade * sizeof(Part);
  Part first;
  std::vector<Part> others;
  double cell_error = 0;
};

// The values from which a lower function of the part is as good as a higher one.
double AreaSearch::most_needed(const Part& part) const {
  // From the nearest corner down: the lower, the less of B matters.
  constexpr double kAbove = 1.125, kNear = 1.03;
  if (!are_shares_alone()) return in_.most;
  const auto& [a, b, c] = part.corners;
  const double nearest = std::min({a.distance, b.distance, c.distance});
  double limit = 0;
  for (const Limit& l : limits_) limit = std::max(limit, l.up);
  return nearest > kNear * limit ? std::min(kAbove * limit, (nearest + limit) / 2) : in_.most;
}

// Whether a part whose corners are not measured should be: its functions are far apart.
bool AreaSearch::is_worth_measuring(const Part& part) {
  constexpr double kLoose = 0.05;
  if (!part.is_rough || !part.has_low) return false;
  double gap = 0;
  for (std::size_t i = 0; i < 3; ++i) gap += part.enclosure.high[i] - part.enclosure.low[i];
  return gap > 3 * kLoose * most(part.enclosure.high);
}

// Whether the part lies under several triangles of B, none of which bounds it well, and is not beyond all limits.
bool AreaSearch::is_worth_cells(const Part& part) const {
  const auto& [a, b, c] = part.corners;
  if (part.is_cell || part.has_failed || (a.slot == b.slot && a.slot == c.slot)) return false;
  constexpr double kLoose = 1.1;
  const Linear& high = part.enclosure.high;
  if (high[0] + high[1] + high[2] <= kLoose * (a.distance + b.distance + c.distance)) return false;
  const double nearest = std::min({a.distance, b.distance, c.distance});
  if (!are_shares_alone()) return true;
  return std::any_of(limits_.begin(), limits_.end(),
                     [&](const Limit& l) { return nearest <= l.up && most(high) > l.down; });
}

// Closes the open parts that need no more work, and notes the contributions of the others. False: interrupted.
bool AreaSearch::sort_out(const Demand& demand, std::vector<double>& wanted) {
  wanted.resize(open_.size());
  const bool is_whole = each_range(stop_, open_.size(), kPartsASum, in_.pool, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      Part& part = open_[i];
      if (!(part.is_open && are_shares_alone())) part.is_open = !is_closed(part);
      wanted[i] = part.is_open ? demand.contribution(part) / area_.weight : 0;
    }
  });
  if (!is_whole) return false;
  std::size_t kept = 0;
  const bool is_sorted = each_unless(stop_, open_.size(), [&](std::size_t i) {
    if (!open_[i].is_open) return close(open_[i]);
    wanted[kept] = wanted[i];
    if (kept < i) open_[kept] = open_[i];
    ++kept;
  });
  if (!is_sorted) return false;
  open_.resize(kept);
  wanted.resize(kept);
  return true;
}

// The parts with the largest contributions, by quarters of a power of two: as many as are likely to make the intervals
// narrow enough, and at most as many as were refined before.
std::vector<std::uint32_t> AreaSearch::choose(const Demand& demand) {
  // Four bins for a power of two.
  constexpr int kBins = 512, kBinOfOne = 128;
  const auto bin_of = [](double wanted) {
    constexpr double kLeast = 0x1p-200;  // its power is a normal number
    const double squared = std::max(wanted, kLeast) * std::max(wanted, kLeast);
    return wanted > 0 ? std::clamp(kBinOfOne - std::ilogb(squared * squared), 0, kBins - 1) : kBins;
  };
  std::vector<double> wanted;
  if (!sort_out(demand, wanted)) return {};
  std::array<double, kBins + 1> sums{};
  double total = 0;
  const bool is_whole = each_unless(stop_, wanted.size(), [&](std::size_t i) {
    sums[static_cast<std::size_t>(bin_of(wanted[i]))] += wanted[i];
    total += wanted[i];
  });
  if (!is_whole) return {};
  const double needed = std::clamp(demand.excess / kGain, kLeastChosenShare * total, kChosenShare * total);
  int last = -1;
  for (double sum = 0; last + 1 < kBins && sum < needed;) sum += sums[static_cast<std::size_t>(++last)];
  std::vector<std::uint32_t> chosen;
  const std::size_t most = std::max(refined_, kMostChosen);
  double sum = 0;
  each_unless(stop_, wanted.size(), [&](std::size_t i) {
    if (chosen.size() == most || sum >= needed || bin_of(wanted[i]) > last) return;
    chosen.push_back(static_cast<std::uint32_t>(i));
    sum += wanted[i];
  });
  refined_ += chosen.size();
  least_chosen_ = area_.weight * power_of_quarters(kBinOfOne - last);
  return chosen;
}

// Within what is left of the work items, and an eighth of the memory.
std::size_t AreaSearch::most_at_once() const {
  const std::uint64_t left = in_.options.max_work_items - std::min(in_.options.max_work_items, work_.subdivisions);
  const std::size_t fit = in_.options.max_memory_bytes / 8 / Refined::kBytes;
  return static_cast<std::size_t>(std::min<std::uint64_t>(left, std::clamp<std::size_t>(fit, 1, kMostChosen)));
}

// Refines the chosen parts, some at a time. Ends early where the budget ends. False: interrupted.
bool AreaSearch::refine(const std::vector<std::uint32_t>& chosen, const Demand& demand) {
  for (std::size_t begin = 0; begin < chosen.size() && !over_budget();) {
    const std::size_t count = std::min(chosen.size() - begin, most_at_once());
    if (!refine_some({chosen.data() + begin, count}, demand)) return false;
    begin += count;
  }
  return true;
}

// False: interrupted, and nothing has changed.
bool AreaSearch::refine_some(std::span<const std::uint32_t> chosen, const Demand& demand) {
  std::vector<Refined> found(chosen.size());
  const std::uint64_t left_of_each = (in_.options.max_work_items - work_.subdivisions) / chosen.size();
  const Foresight aim{demand, least_chosen_};
  std::atomic<bool> stopped{false};
  std::vector<Work> works(in_.pool.size());
  in_.pool.run(tasks_for(chosen.size(), kPartsATask), [&](std::size_t worker, std::size_t task) {
    if (stopped || stop_()) stopped = true;
    const std::size_t end = std::min(chosen.size(), (task + 1) * kPartsATask);
    for (std::size_t i = task * kPartsATask; i < end && !stopped; ++i) {
      found[i].first = open_[chosen[i]];
      if (!refine_part(bounders_[worker], aim, left_of_each, works[worker], found[i])) stopped = true;
    }
  });
  for (const Work& work : works) work_ += work;
  if (stopped) return false;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    open_[chosen[i]] = found[i].first;
    for (const Part& part : found[i].others) {
      is_closed(part) ? close(part) : open_.push_back(part);
    }
    found[i].others = {};
    area_.cell_error += found[i].cell_error;
  }
  return true;
}

// Gives the part a lower function, or else divides it and gives one to the parts that still contribute. False:
// interrupted.
bool AreaSearch::refine_part(PartBounder& bounder, const Foresight& aim, std::uint64_t most_parts, Work& work,
                             Refined& refined) {
  const Demand& demand = aim.demand;  // clang 14 captures no structured bindings
  Part& first = refined.first;
  first.is_open = false;
  const auto bound = [&](Part& part) { return bounder.bound_below(part, most_needed(part), work, &stop_); };
  const auto needs_low = [&](const Part& part) { return demand.needs_low(part, bounder.floor_of(part)); };
  const auto bound_if_wanted = [&](Part& part) {
    return !(needs_low(part) && demand.contribution(part) >= aim.least) || bound(part);
  };
  if (is_worth_measuring(first) && !bounder.measure(first, work, &stop_)) return false;
  std::optional<CellParts> cells;
  if (is_worth_cells(first)) {
    cells = bounder.cells(first, most_parts, work);
    first.has_failed = !cells;
  }
  if (cells) {
    if (!bound_cells(bounder, aim, *cells, work)) return false;
    first = cells->parts.back();
    cells->parts.pop_back();
    refined.others = std::move(cells->parts);
    refined.cell_error = cells->error;
    return true;
  }
  if (!first.has_low && (needs_low(first) || !bounder.can_split(first))) return bound(first);
  const auto parts = bounder.split(first, work, &stop_);
  if (!parts) return false;
  first = (*parts)[0];
  refined.others = {(*parts)[1]};
  return bound_if_wanted(first) && bound_if_wanted(refined.others[0]);
}

// Refines a triangle as far as the sample's triangles were.
bool AreaSearch::refine_triangle(PartBounder& bounder, const Part& whole, std::uint64_t most_parts, Bounded& found) {
  const auto& [demand, least] = *foresight_;
  const std::size_t begin = found.parts.size();
  const std::uint64_t end = found.work.subdivisions + std::min<std::uint64_t>(most_parts, kMostOfTriangle);
  std::vector<Part> waiting{whole};
  while (!waiting.empty()) {
    if (stop_()) return false;
    Part part = waiting.back();
    waiting.pop_back();
    const bool is_full = found.parts.size() - begin + waiting.size() >= kMostOfTriangle;
    if (is_full || found.work.subdivisions >= end || demand.contribution(part) < least || is_closed(part)) {
      found.parts.push_back(part);
      continue;
    }
    Refined refined{part, {}, 0};
    if (!refine_part(bounder, {demand, least}, end - found.work.subdivisions, found.work, refined)) return false;
    found.cell_error += refined.cell_error;
    waiting.push_back(refined.first);
    waiting.insert(waiting.end(), refined.others.begin(), refined.others.end());
  }
  return true;
}

// Gives the cells that still contribute lower functions. False: interrupted.
bool AreaSearch::bound_cells(PartBounder& bounder, const Foresight& aim, CellParts& cells, Work& work) {
  const auto& [demand, least] = aim;
  std::size_t begin = 0;
  for (const std::size_t end : cells.fans) {
    for (; begin < end; begin += std::min(end - begin, PartBounder::kMostOfFan)) {
      const std::span<Part> fan(cells.parts.data() + begin, std::min(end - begin, PartBounder::kMostOfFan));
      double most = 0, contribution = 0;
      for (const Part& part : fan) {
        most = std::max(most, most_needed(part));
        if (demand.needs_low(part, bounder.floor_of(part))) contribution += demand.contribution(part);
      }
      if (contribution < least) continue;
      if (!bounder.bound_fan_below(fan, most, work, &stop_)) return false;
    }
  }
  return true;
}

// Whether a round could need too much: what is held, what choose() and quantile() note of each part, and what is made.
bool AreaSearch::over_budget() const {
  constexpr std::size_t kNotes = 80;  // also for the blocks of a deque
  const std::size_t open = open_.size() * (sizeof(Part) + kNotes);
  const std::size_t closed = closed_.size() * (sizeof(WeightedEnclosure) + kNotes);
  const std::size_t made = std::min(open_.size(), most_at_once()) * Refined::kBytes;
  return bytes_of(corners_) + open + closed + made > in_.options.max_memory_bytes ||
         work_.subdivisions >= in_.options.max_work_items;
}

}  // namespace meshgauge
