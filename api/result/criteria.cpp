#include "api/result/criteria.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <nlohmann/json.hpp>

#include "api/base/figures.h"
#include "api/options/gate.h"
#include "api/options/names.h"
#include "api/options/request.h"
#include "api/result/examination.h"
#include "api/result/json_of.h"
#include "api/result/result_document.h"

namespace meshgauge::api {
namespace {

constexpr Name<Criterion::Of> kOf[] = {{Criterion::Of::distance, "distance"},
                                       {Criterion::Of::share, "share"},
                                       {Criterion::Of::expectation, "expectation"}};
constexpr int kWordDigits = 6;

std::optional<Criterion::Place> place_of(const std::optional<Witness>& witness, bool on_a) {
  if (!witness) return std::nullopt;
  return Criterion::Place{on_a, witness->point_a, witness->triangle_a, witness->point_b, witness->triangle_b};
}

const Bounds* bounds_of(const std::optional<Bounds>& found) { return found ? &*found : nullptr; }
const Bounds* bounds_of(const std::optional<Directed>& found) { return found ? &found->bounds : nullptr; }

// Returns the place of the direction that attains the larger lower bound.
std::optional<Criterion::Place> place_of(const Bounds* a_to_b, const Bounds* b_to_a) {
  const bool has_a = a_to_b && a_to_b->witness, has_b = b_to_a && b_to_a->witness;
  if (has_b && (!has_a || b_to_a->lower > a_to_b->lower)) return place_of(b_to_a->witness, false);
  return has_a ? place_of(a_to_b->witness, true) : std::nullopt;
}

std::string name_of_distance(const Criterion& criterion) {
  if (!criterion.side.empty()) return "distance " + criterion.side;
  if (criterion.region.empty()) return "distance";
  return criterion.is_of_region() ? "distance in " + criterion.region : "distance outside of all regions";
}

// `found`: an Outcome or a RegionOutcome.
Criterion of_distance(double limit, const auto& found) {
  Criterion criterion;
  criterion.limit = limit;
  criterion.lower = found.lower;
  criterion.upper = found.upper;
  criterion.status = name_of(kStops, found.stop);
  criterion.at = place_of(bounds_of(found.a_to_b), bounds_of(found.b_to_a));
  return criterion;
}

Criterion of_side(const char* side, double limit, SideBounds SideOutcome::*bounds, const Outcome& outcome,
                  const std::optional<LengthUnit>& unit) {
  Criterion criterion;
  criterion.side = side;
  criterion.limit = limit;
  if (!outcome.sides) return criterion;
  criterion.status = name_of(kAreaStops, outcome.sides->stop);
  if (const auto& refused = outcome.sides->refused) {
    criterion.refused = in_words(*refused, unit);
    return criterion;
  }
  const SideBounds& found = (*outcome.sides).*bounds;
  criterion.lower = found.lower;
  criterion.upper = found.upper;
  if (found.at) criterion.at = Criterion::Place{true, *found.at, found.triangle, std::nullopt, 0};
  return criterion;
}

// Why the work on the areas ended: that of the first direction whose work did not end by itself.
std::string_view area_status(const AreaOutcome& areas) {
  for (const auto* found : {&areas.a_to_b, &areas.b_to_a}) {
    if (*found && (*found)->stop != AreaStop::complete) return name_of(kAreaStops, (*found)->stop);
  }
  return name_of(kAreaStops, AreaStop::complete);
}

// In the direction where the share is largest, from that beyond the farther end of its distance to that beyond the
// nearer one; from 0 to 1 where the areas of a direction are missing. engine_options() has asked for them, last of all.
Criterion of_share(const Outcome& outcome, const ComparisonOptions& options) {
  const AreaOutcome areas = outcome.areas.value_or(AreaOutcome{});
  const auto& [beyond, most] = *options.max_share_beyond;
  Criterion share;
  share.of = Criterion::Of::share;
  share.beyond = beyond;
  share.limit = most;
  share.upper = 0;
  share.status = area_status(areas);
  const std::size_t asked = options.ends(beyond).are_apart() ? 2 : 1;
  const auto add = [&](const std::optional<AreaBounds>& found) {
    const bool known = found && found->beyond.size() >= asked;
    share.lower = std::max(share.lower, known ? found->beyond.back().lower : 0);
    share.upper = std::max(share.upper, known ? found->beyond[found->beyond.size() - asked].upper : 1);
  };
  if (options.direction != Direction::b_to_a) add(areas.a_to_b);
  if (options.direction != Direction::a_to_b) add(areas.b_to_a);
  return share;
}

// The greatest is the foremost.
std::tuple<int, bool, double> foremost_rank(const Criterion& c) {
  const bool is_limit = c.of != Criterion::Of::expectation;
  const double end = c.verdict == Verdict::fail ? c.lower : c.upper;
  return {severity(c.verdict), is_limit, end / std::max(c.limit, std::numeric_limits<double>::min())};
}

std::string share_finding(const Criterion& share, std::string_view unit) {
  const IntervalText figures = figures_of(share);
  const std::string found = share_in_words(share, unit);
  if (share.verdict != Verdict::undecided) return found + "; at most " + figures.limit + " % may be";
  return found + ": whether at most " + figures.limit + " % are is not known (" + share.status + ")";
}

std::string distance_finding(const Criterion& criterion, std::string_view unit, std::string limit) {
  if (!criterion.refused.empty()) return "nothing is inside or outside: " + criterion.refused;
  const IntervalText figures = figures_of(criterion);
  if (limit.empty()) limit = with_unit(figures.limit, unit) + plus_minus(criterion, unit);
  const std::string is = "the " + criterion.name + " is ", lower = with_unit(figures.lower, unit),
                    upper = with_unit(figures.upper, unit);
  if (criterion.verdict == Verdict::pass) return is + "at most " + upper + ", within the limit of " + limit;
  if (criterion.verdict == Verdict::fail) return is + "at least " + lower + ", above the limit of " + limit;
  const std::string range =
      std::isfinite(criterion.upper) ? "between " + figures.lower + " and " + upper : "at least " + lower;
  return is + range + ": whether that is within the limit of " + limit + " is not known (" + criterion.status + ")";
}

// A share times 100, rounded towards `towards` unless it is exact.
double percent(double share, double towards) {
  return share > 0 && share < 1 ? std::nextafter(100 * share, towards) : 100 * share;
}

Json place_json(const std::optional<Criterion::Place>& at) {
  if (!at) return nullptr;
  return {{"on", at->on_a ? "a" : "b"},
          {"point", json_of(at->point)},
          {"triangle", at->triangle},
          {"nearest_point", at->nearest ? json_of(*at->nearest) : Json(nullptr)},
          {"nearest_triangle", at->nearest ? Json(at->nearest_triangle) : Json(nullptr)}};
}

std::uint32_t read_triangle(const Json& json) {
  const auto index = json.get<double>();
  return in_range(index, {0, 0xFFFFFFFF, true}, "").ok() ? static_cast<std::uint32_t>(index) : 0;
}

std::optional<Criterion::Place> read_place(const Json& json) {
  if (json.is_null()) return std::nullopt;
  Criterion::Place place{json.at("on") != "b", point_of(json.at("point")), read_triangle(json.at("triangle")),
                         std::nullopt, 0};
  if (const Json& nearest = json.at("nearest_point"); !nearest.is_null()) {
    place.nearest = point_of(nearest);
    place.nearest_triangle = read_triangle(json.at("nearest_triangle"));
  }
  return place;
}

Error no_criterion(const std::string& why) { return {ErrorCode::internal, "no criterion: " + why, "", ""}; }

bool is_interval(const Criterion& c) {
  const bool is_share = c.of == Criterion::Of::share;
  if (!c.refused.empty() && (c.side.empty() || c.lower != 0 || std::isfinite(c.upper))) return false;
  return c.lower >= 0 && c.lower <= c.upper && (!is_share || (c.upper <= 1 && c.beyond));
}

}  // namespace

bool Criterion::is_of_region() const { return !region.empty() && region != kRest; }

bool Criterion::is_of_whole() const { return of == Of::distance && side.empty() && !is_of_region(); }

bool Criterion::is_known() const {
  if (of == Of::expectation) return in_time;
  return std::isfinite(upper) && (of != Of::share || lower > 0 || upper < 1);
}

Verdict verdict_of(const Criterion& limit) {
  if (!limit.refused.empty()) return Verdict::undecided;
  return verdict_within(limit.lower, limit.upper, limit.ends());
}

bool is_same_limit(const Criterion& one, const Criterion& other) {
  return one.of == other.of && one.region == other.region && one.side == other.side && one.beyond == other.beyond &&
         one.limit == other.limit && one.uncertainty == other.uncertainty;
}

Criterion judged(Criterion limit) {
  limit.name = limit.of == Criterion::Of::share ? "share beyond" : name_of_distance(limit);
  limit.verdict = verdict_of(limit);
  return limit;
}

std::vector<Criterion> criteria_of(const Outcome& outcome, const ComparisonOptions& options,
                                   const std::optional<LengthUnit>& unit) {
  std::vector<Criterion> criteria;
  const auto add = [&](Criterion limit, std::string region = {}) {
    limit.region = std::move(region);
    limit.uncertainty = options.uncertainty;
    criteria.push_back(judged(std::move(limit)));
  };
  const auto& regions = outcome.regions;
  if (options.max_distance && regions.empty()) add(of_distance(*options.max_distance, outcome));
  if (options.max_distance && !regions.empty())
    add(of_distance(*options.max_distance, regions.back()), std::string(kRest));
  if (const auto& zone = options.zone) {
    add(of_side("inside", zone->inside, &SideOutcome::inside, outcome, unit));
    add(of_side("outside", zone->outside, &SideOutcome::outside, outcome, unit));
  }
  for (std::size_t i = 0; options.max_distance && i + 1 < regions.size(); ++i)
    add(of_distance(*limit_of_region(options, i), regions[i]), options.regions[i].name);
  if (options.max_share_beyond) add(of_share(outcome, options));
  return criteria;
}

std::vector<Criterion> limits_asked(const ComparisonOptions& options) {
  Outcome nothing;
  if (!options.regions.empty()) nothing.regions.resize(options.regions.size() + 1);
  return criteria_of(nothing, options);
}

std::vector<Criterion> criteria_of(const Comparison& comparison) {
  return criteria_of(comparison, expectations_of(comparison));
}

std::vector<Criterion> criteria_of(const Comparison& comparison, const std::vector<Criterion>& expectations) {
  auto criteria = criteria_of(comparison.outcome, comparison.options, comparison.units.result.unit);
  criteria.insert(criteria.end(), expectations.begin(), expectations.end());
  return criteria;
}

// While sides are not known, only their limits are: then the larger one is shown, as of a pass.
std::optional<DistanceLimit> shown_limit(std::span<const Criterion> criteria) {
  const auto area = std::ranges::find_if(criteria, [](const Criterion& c) { return c.beyond.has_value(); });
  if (area != criteria.end() && std::ranges::none_of(criteria, &Criterion::is_of_whole))
    return DistanceLimit{*area->beyond};
  std::optional<DistanceLimit> shown;
  std::tuple<int, bool, double> highest{-2, false, 0};
  for (const Criterion& one : criteria) {
    if (!one.is_of_whole() && one.side.empty()) continue;
    const bool is_known = one.side.empty() || one.is_known();
    const int worse = is_known ? severity(one.verdict) : -1;
    const std::tuple rank(worse, one.side.empty(), worse > 0 ? -one.limit : one.limit);
    if (rank <= highest) continue;
    highest = rank;
    shown = DistanceLimit{one.limit, is_known ? one.side : ""};
  }
  return shown;
}

std::optional<Verdict> worst(std::span<const Criterion> criteria) {
  if (criteria.empty()) return std::nullopt;
  return std::ranges::max_element(criteria, {}, [](const Criterion& c) { return severity(c.verdict); })->verdict;
}

const Criterion& foremost(std::span<const Criterion> criteria) {
  return *std::ranges::max_element(criteria, {}, foremost_rank);
}

std::vector<Criterion> foremost_first(std::vector<Criterion> criteria) {
  const auto first = std::ranges::max_element(criteria, {}, foremost_rank);
  if (first != criteria.end()) std::rotate(criteria.begin(), first, first + 1);
  return criteria;
}

const Criterion* foremost_place(std::span<const Criterion> criteria) {
  const Criterion* found = nullptr;
  const auto verdict = worst(criteria);
  for (const Criterion& one : criteria) {
    if (one.verdict != verdict || !one.at) continue;
    if (!found || foremost_rank(*found) < foremost_rank(one)) found = &one;
  }
  return found;
}

IntervalText figures_of(const Criterion& criterion) {
  if (criterion.of == Criterion::Of::share) {
    const Criterion shown = in_percent(criterion);
    return to_text(shown.lower, shown.upper, shown.limit);
  }
  const LimitEnds ends = criterion.ends();
  double shown = criterion.limit;
  if (criterion.verdict == Verdict::pass) shown = ends.pass;
  if (criterion.verdict == Verdict::fail) shown = ends.fail;
  IntervalText text = to_text(criterion.lower, criterion.upper, shown);
  if (ends.are_apart()) text.limit = to_digits(criterion.limit, kWordDigits);
  return text;
}

Criterion in_percent(Criterion share) {
  share.lower = percent(share.lower, 0);
  share.upper = percent(share.upper, 100);
  share.limit *= 100;
  return share;
}

std::string share_in_words(const Criterion& share, std::string_view unit) {
  const IntervalText figures = figures_of(share);
  const std::string beyond = " of the area is farther than " + with_unit(to_digits(*share.beyond, kWordDigits), unit) +
                             plus_minus(share, unit);
  if (!(share.upper > 0)) return "none" + beyond;
  if (!(share.lower > 0)) return "at most " + figures.upper + " %" + beyond;
  if (!(share.upper < 1)) return "at least " + figures.lower + " %" + beyond;
  return "between " + figures.lower + " and " + figures.upper + " %" + beyond;
}

std::string finding_of(const Criterion& criterion, std::string_view unit, const std::string& limit) {
  switch (criterion.of) {
    case Criterion::Of::distance:
      return distance_finding(criterion, unit, limit);
    case Criterion::Of::share:
      return share_finding(criterion, unit);
    default:
      return criterion.name + ": " + criterion.found + ", expected " + criterion.expected;
  }
}

std::string why_open(const Criterion& limit) {
  const std::string what = limit.of == Criterion::Of::share ? "share" : "distance";
  return limit.is_uncertain() ? "the " + what + " is closer to its limit than the uncertainty lets be told"
                              : "the limit is within rounding error of the " + what;
}

Json terms_json(const LimitTerms& terms) {
  return terms.is_uncertain() ? Json{{"uncertainty", terms.uncertainty}} : Json::object();
}

LimitTerms terms_in(const Json& object) {
  const auto found = object.find("uncertainty");
  return {found != object.end() && found->is_number() ? found->get<double>() : 0};
}

Json json_of(const Criterion& criterion, std::string_view unit) {
  Json json{{"name", criterion.name}, {"of", name_of(kOf, criterion.of)}, {"verdict", to_string(criterion.verdict)}};
  const std::string finding = finding_of(criterion, unit);
  if (criterion.of == Criterion::Of::expectation) {
    json.update({{"expected", criterion.expected}, {"found", criterion.found}, {"finding", finding}});
    return json;
  }
  json.update({{"region", text_or_null(criterion.region)},
               {"side", text_or_null(criterion.side)},
               {"beyond", number_or_null(criterion.beyond)},
               {"limit", criterion.limit},
               {"uncertainty", criterion.uncertainty},
               {"unit", text_or_null(unit)},
               {"lower", criterion.lower},
               {"upper", criterion.upper},
               {"status", text_or_null(criterion.status)},
               {"witness", place_json(criterion.at)},
               {"refused", text_or_null(criterion.refused)},
               {"finding", finding}});
  return json;
}

Result<Criterion> read_criterion(const Json& json) try {
  const auto text = [&](const char* member) {
    const Json& found = json.at(member);
    return found.is_null() ? std::string() : found.get<std::string>();
  };
  const auto of = value_of(kOf, text("of"));
  const auto verdict = value_of(kVerdicts, text("verdict"));
  if (!of || !verdict) return no_criterion("its kind or its verdict is unknown");
  Criterion criterion;
  criterion.of = *of;
  criterion.name = text("name");
  criterion.verdict = *verdict;
  if (*of == Criterion::Of::expectation) {
    criterion.expected = text("expected");
    criterion.found = text("found");
    return criterion;
  }
  criterion.region = text("region");
  criterion.side = text("side");
  if (const Json& beyond = json.at("beyond"); !beyond.is_null()) criterion.beyond = beyond.get<double>();
  criterion.limit = json.at("limit").get<double>();
  criterion.uncertainty = json.at("uncertainty").get<double>();
  criterion.lower = json.at("lower").get<double>();
  criterion.upper = upper_of(json);
  criterion.status = text("status");
  criterion.refused = text("refused");
  criterion.at = read_place(json.at("witness"));
  if (!is_interval(criterion)) return no_criterion("its bounds are no interval");
  return judged(std::move(criterion));
} catch (const Json::exception& error) {
  return no_criterion(error.what());
}

std::vector<Criterion> read_criteria(const Json& document) {
  std::vector<Criterion> criteria;
  const auto all = document.find("criteria");
  if (all == document.end()) return criteria;
  for (const Json& json : *all) {
    if (auto criterion = read_criterion(json)) criteria.push_back(*std::move(criterion));
  }
  return criteria;
}

}  // namespace meshgauge::api
