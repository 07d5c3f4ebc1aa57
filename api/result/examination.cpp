#include "api/result/examination.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

#include "api/base/figures.h"
#include "api/result/json_of.h"
#include "engine/rounding.h"

namespace meshgauge::api {
namespace {

constexpr int kFoundDigits = 10;
constexpr double kNoEnd = std::numeric_limits<double>::infinity();

struct Found {
  double lower = 0;
  double upper = 0;
};

// Null if it is missing.
const Json& found_at(const Json& json, const std::string& pointer) {
  static const Json kNull;
  const Json::json_pointer path(pointer);
  return json.contains(path) ? json.at(path) : kNull;
}

std::optional<Found> count_at(const Json& json) {
  return json.is_number() ? std::optional(Found{json.get<double>(), json.get<double>()}) : std::nullopt;
}

// Null ends are beyond the range of numbers.
std::optional<Found> ends_of(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  const Json &lower = found_at(json, "/lower"), &upper = found_at(json, "/upper");
  return Found{lower.is_number() ? lower.get<double>() : -kNoEnd, upper.is_number() ? upper.get<double>() : kNoEnd};
}

Verdict verdict_in(const Found& found, const Span& span) {
  if ((span.max && found.lower > *span.max) || (span.min && found.upper < *span.min)) return Verdict::fail;
  const bool inside = (!span.max || found.upper <= *span.max) && (!span.min || found.lower >= *span.min);
  return inside ? Verdict::pass : Verdict::undecided;
}

// Whether |found - of| <= share * |of|, for all or for no numbers of the two intervals.
Verdict is_within(const Found& found, const Found& of, double share) {
  const Found difference{rounding::down(found.lower - of.upper), rounding::up(found.upper - of.lower)};
  const double most = std::max(-difference.lower, difference.upper);
  const double least = std::max({difference.lower, -difference.upper, 0.0});
  const double smallest = std::max({of.lower, -of.upper, 0.0}), largest = std::max(-of.lower, of.upper);
  if (most <= rounding::down(share * smallest)) return Verdict::pass;
  return least > rounding::up(share * largest) ? Verdict::fail : Verdict::undecided;
}

std::string in_figures(double number, const std::string& unit) {
  return with_unit(to_digits(number, kFoundDigits), unit);
}

std::string in_figures(const Found& interval, const std::string& unit) {
  const double middle = interval.lower / 2 + interval.upper / 2;
  const bool narrow = interval.upper - interval.lower <= 1e-10 * std::abs(middle);
  return narrow ? in_figures(middle, unit)
                : to_digits(interval.lower, kFoundDigits) + " .. " + in_figures(interval.upper, unit);
}

std::string in_figures(const Span& span, const std::string& unit) {
  if (!span.min) return "at most " + in_figures(*span.max, unit);
  if (!span.max) return "at least " + in_figures(*span.min, unit);
  return *span.min == *span.max ? in_figures(*span.min, unit)
                                : to_digits(*span.min, kFoundDigits) + " to " + in_figures(*span.max, unit);
}

// Collects the expectations of one result.
class Examination {
 public:
  Examination(const Json& meshes, const std::string& unit) : meshes_(meshes), unit_(unit) {}

  void examine(const char* name, const std::optional<bool>& expected, const std::string& defects) {
    if (!expected) return;
    const Json& found = found_at(meshes_, std::string("/a/topology/") + name);
    const char* const words[] = {"no", "yes"};
    if (!found.is_boolean()) return unknown(name, words[*expected]);
    const bool is = found.get<bool>() && found_at(meshes_, "/a/topology/edges") != 0;  // a cloud has none
    add(name, is == *expected ? Verdict::pass : Verdict::fail,
        words[is] + (is || defects.empty() ? "" : ": " + defects), words[*expected]);
  }

  void examine(const char* name, const std::optional<Span>& expected, const char* place) {
    if (!expected) return;
    const auto found = count_at(found_at(meshes_, place));
    if (!found) return unknown(name, in_figures(*expected, ""));
    add(name, verdict_in(*found, *expected), in_figures(*found, ""), in_figures(*expected, ""));
  }

  void examine_volume(const Expectations& expect) {
    const auto a = volume_of("a"), b = volume_of("b");
    const std::string unit = cubic();
    if (expect.volume) {
      const std::string expected = in_figures(*expect.volume, unit);
      if (known("volume", "a", expected)) add("volume", verdict_in(*a, *expect.volume), volume_in_words(*a), expected);
    }
    if (!expect.volume_within) return;
    std::string expected = "within " + to_digits(100 * *expect.volume_within, kFoundDigits) + " % of the baseline's ";
    for (const char* mesh : {"a", "b"}) {
      if (!known("volume.within", mesh, expected + "volume")) return;
    }
    expected += in_figures(*b, unit);
    add("volume.within", is_within(*a, *b, *expect.volume_within), volume_in_words(*a), expected);
  }

  // "4 open edges, the first at (0.5, 0, 1) mm"; empty without such an edge.
  std::string edges(const char* kind, const char* member) const {
    const Json& found = found_at(meshes_, std::string("/a/topology/") + member);
    const Json &count = found_at(found, "/count"), &first = found_at(found, "/first");
    const bool is_place = first.is_array() && first.size() == 3 &&
                          std::all_of(first.begin(), first.end(), [](const Json& x) { return x.is_number(); });
    if (!count.is_number_integer() || count.get<std::int64_t>() <= 0 || !is_place) return "";
    const Vec3 place(first[0].get<double>(), first[1].get<double>(), first[2].get<double>());
    return edges_in_words(count.get<std::uint64_t>(), kind, place, unit_);
  }

  std::vector<Criterion> take() && { return std::move(all_); }

 private:
  void add(const char* name, Verdict verdict, std::string found, std::string expected) {
    all_.push_back(expectation(name, verdict, std::move(found), std::move(expected)));
  }
  void unknown(const char* name, std::string expected) {
    const char* const found = "not known: the time ended before";
    all_.push_back(expectation(name, Verdict::undecided, found, std::move(expected), false));
  }

  std::optional<Found> volume_of(const std::string& mesh) const {
    return ends_of(found_at(meshes_, "/" + mesh + "/topology/volume"));
  }

  // Whether the mesh has a volume. Else adds the reason.
  bool known(const char* name, const std::string& mesh, const std::string& expected) {
    if (volume_of(mesh)) return true;
    const Json& watertight = found_at(meshes_, "/" + mesh + "/topology/watertight");
    if (!watertight.is_boolean()) return unknown(name, expected), false;
    add(name, Verdict::fail,
        std::string("none: the ") + (mesh == "a" ? "candidate" : "baseline") + " is not " +
            (watertight.get<bool>() ? "oriented" : "watertight"),
        expected);
    return false;
  }

  std::string volume_in_words(const Found& volume) const {
    return in_figures(volume, cubic()) + (volume.upper < 0 ? ": its triangles face inwards" : "");
  }

  std::string cubic() const { return unit_.empty() ? "" : unit_ + "^3"; }

  const Json& meshes_;
  const std::string& unit_;
  std::vector<Criterion> all_;
};

}  // namespace

Criterion expectation(std::string name, Verdict verdict, std::string found, std::string expected, bool in_time) {
  Criterion made;
  made.of = Criterion::Of::expectation;
  made.name = std::move(name);
  made.verdict = verdict;
  made.expected = std::move(expected);
  made.found = std::move(found);
  made.in_time = in_time;
  return made;
}

Json expectations_json(const std::vector<Criterion>& expectations) {
  auto json = Json::array();
  for (const Criterion& one : expectations)
    json.push_back(
        {{"name", one.name}, {"verdict", to_string(one.verdict)}, {"found", one.found}, {"expected", one.expected}});
  return json;
}

std::vector<Criterion> examined(const Expectations& expect, const Json& meshes, const std::string& unit) {
  Examination examination(meshes, unit);
  const std::string open = examination.edges("open", "open_edges");
  const std::string crowded = examination.edges("non-manifold", "non_manifold_edges");
  examination.examine("watertight", expect.watertight, open + (open.empty() || crowded.empty() ? "" : "; ") + crowded);
  examination.examine("oriented", expect.oriented, examination.edges("flipped", "flipped_edges"));
  examination.examine("triangles", expect.triangles, "/a/triangles");
  examination.examine("degenerate", expect.degenerate, "/a/degenerate");
  examination.examine("components", expect.components, "/a/topology/components");
  if (expect.volume || expect.volume_within) examination.examine_volume(expect);
  return std::move(examination).take();
}

std::vector<Criterion> expectations_of(const Comparison& comparison) {
  if (!comparison.options.expect.any()) return {};
  return examined(comparison.options.expect, meshes_of(comparison),
                  std::string(to_string(comparison.units.result.unit)));
}

}  // namespace meshgauge::api
