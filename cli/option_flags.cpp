#include "cli/option_flags.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <CLI/CLI.hpp>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/options/unit_plan.h"
#include "check/manifest/yaml_json.h"

namespace meshgauge::cli {
namespace {

using nlohmann::json;

enum class Takes {
  value,  // a number or a word
  text,   // a word
  yaml,   // as in a manifest
  area,   // "0.05 mm: 1 %"
  zone,   // "-0.05 mm, 0.1 mm"
  list,   // "0.05,0.1"
  on,     // nothing: true
  off     // nothing: false
};

constexpr unsigned kCompare = 1, kCheck = 2, kBoth = kCompare | kCheck;

struct Row {
  std::string_view flag;
  std::string_view pointer;  // in the document
  Takes takes;
  unsigned commands;
  const char* help;
};

constexpr Row kRows[] = {
    {"--max-distance", "/max_distance", Takes::value, kBoth,
     "The largest distance that passes: '0.05', '0.05 mm', or '0.5 %' of the diagonal of the second mesh"},
    {"--max-share-beyond", "/max_share_beyond", Takes::area, kBoth,
     "The largest share of the area that may be farther than a distance: '0.05 mm: 1 %'"},
    {"--zone", "/zone", Takes::zone, kBoth,
     "How far the first mesh may be inside and outside of the second, a closed one: '-0.05 mm, 0.1 mm'"},
    {"--uncertainty", "/uncertainty", Takes::value, kBoth,
     "Of the distances: pass and fail only by more than this; '0.01 mm' (ISO 14253-1)"},
    {"--regions", "/regions", Takes::yaml, kBoth,
     "Measure these parts by themselves: '[{name: bore, box: {min: [0, 0, 0], max: [9, 9, 9]}, max_distance: 0.02 "
     "mm}]'; or sphere: {centre: [0, 0, 0], radius: 5}, or group: NAME, a group of the second file"},
    {"--expect", "/expect", Takes::yaml, kBoth,
     "What the first mesh itself has to be like: '{watertight: true, triangles: {max: 20000}}'; docs/check.md"},
    {"--unit", "/units", Takes::text, kBoth,
     "The unit of both files, whatever they say themselves: um, mm, cm, m, in, ft"},
    {"--unit-a", "/units/candidate", Takes::text, kBoth, "The unit of the first file"},
    {"--unit-b", "/units/baseline", Takes::text, kBoth, "The unit of the second file"},
    {"--direction", "/direction", Takes::value, kBoth,
     "symmetric; a_to_b, candidate_to_baseline: from the first mesh; b_to_a, baseline_to_candidate"},
    {"--align", "/align", Takes::yaml, kBoth,
     "Move the first mesh first: 'rigid' by best fit, or as '{transform: {row_major: [16 numbers]}}'; "
     "docs/alignment.md"},
    {"--timeout", "/timeout", Takes::value, kBoth,
     "Of each gate or comparison: '60 s', '500 ms', or a number of seconds"},
    {"--timeout-ms", "/timeout_ms", Takes::value, kCompare, "As --timeout, in milliseconds; else 30000"},
    {"--strategy", "/strategy", Takes::value, kBoth, "auto, four_point, n_point, triangle_set"},
    {"--points", "/points", Takes::value, kBoth,
     "Samples a piece, for the strategy n_point: 4, 10, 31, 109, 409, 1585"},
    {"--threads", "/threads", Takes::value, kBoth,
     "At most so many threads for a gate or comparison; 0: as many as there are processors, which gates share"},
    {"--absolute", "/tolerance/absolute", Takes::value, kBoth, "Stop when upper - lower is at most this"},
    {"--diagonal", "/tolerance/diagonal", Takes::value, kBoth,
     "Stop when upper - lower is at most this part of the first mesh's diagonal"},
    {"--relative", "/tolerance/relative", Takes::value, kBoth, "Stop when upper - lower is at most this part of lower"},
    {"--fast", "/narrow", Takes::off, kBoth, "End as soon as the gate is decided, without narrowing the interval"},
    {"--statistics", "/statistics", Takes::on, kBoth, "Sample mean, RMS, percentiles and a histogram as well"},
    {"--samples", "/statistics/samples", Takes::value, kBoth,
     "Points sampled in each direction, 1000 to 1000000; else 100000"},
    {"--seed", "/statistics/seed", Takes::value, kBoth, "Another one samples other points; else 1"},
    {"--work-items", "/budget/work_items", Takes::value, kCompare, "Stop after splitting so many pieces"},
    {"--memory-bytes", "/budget/memory_bytes", Takes::value, kCompare,
     "Stop when the waiting pieces need more than this"},
    {"--beyond", "/areas/beyond", Takes::list, kCompare,
     "Certify the share of the area beyond these distances: 0.05,0.1"},
    {"--quantiles", "/areas/quantiles", Takes::list, kCompare,
     "Certify the distances that these shares are within: 0.95,0.99"},
    {"--mean", "/areas/mean", Takes::on, kCompare, "Certify the mean and the root mean square of the distance"},
    {"--share-tolerance", "/areas/share_tolerance", Takes::value, kCompare, "Width of a certified share; else 0.001"},
    {"--length-tolerance", "/areas/length_tolerance", Takes::value, kCompare,
     "Width of a certified quantile or mean, relative to it; else 0.01"},
    {"--sides", "/sides", Takes::on, kCompare,
     "Certify how far the first mesh reaches outside and inside of the second, which must be closed"},
    {"--topology", "/topology", Takes::on, kCompare,
     "Also examine both meshes: open edges, orientation, components, volume"}};

// The flag of a pointer, with what is below it: "--regions[0].box".
std::string flag_of(std::string_view pointer) {
  const Row* best = nullptr;
  for (const Row& row : kRows) {
    const bool holds = pointer.starts_with(row.pointer) &&
                       (pointer.size() == row.pointer.size() || pointer[row.pointer.size()] == '/');
    if (holds && (!best || row.pointer.size() > best->pointer.size())) best = &row;
  }
  if (best) {
    const std::string below = api::dotted(pointer.substr(best->pointer.size()));
    return std::string(best->flag) + (below.empty() || below.starts_with('[') ? "" : ".") + below;
  }
  const auto* const part =
      std::ranges::find_if(kRows, [&](const Row& row) { return row.pointer.starts_with(pointer); });
  return part == std::end(kRows) ? api::dotted(pointer) : std::string(part->flag);
}

// The words of a manifest, and the names of flags. kManifest is a constant, thus initialized before.
api::Surface flags() {
  api::Surface surface = check::kManifest;
  surface.bit = api::Surface::flags;
  surface.name = flag_of;
  return surface;
}

// The meshes of `compare` are A and B.
api::Surface flags_of_compare() {
  api::Surface surface = flags();
  surface.a = "A", surface.b = "B";
  surface.a_to_b = "a_to_b", surface.b_to_a = "b_to_a";
  return surface;
}

const api::Surface kCheckFlags = flags(), kCompareFlags = flags_of_compare();

json word(std::string_view text) {
  check::YamlNode node;
  node.kind = check::YamlNode::Kind::word;
  node.text = text;
  return check::json_of(node);
}

Result<json> flow(const std::string& flag, const std::string& text) {
  check::Mistakes mistakes;
  const auto tree = check::parse_yaml(text, mistakes);
  const auto found = std::move(mistakes).sorted();
  if (!found.empty()) return bad_flag(flag, found.front().message);
  return check::json_of(*tree);
}

json list(std::string_view text) {
  json all = json::array();
  for (;;) {
    const std::size_t comma = text.find(',');
    all.push_back(word(api::trimmed(text.substr(0, comma))));
    if (comma == std::string_view::npos) return all;
    text.remove_prefix(comma + 1);
  }
}

Result<json> value_of(const Row& row, const std::string& text) {
  switch (row.takes) {
    case Takes::on:
      return json(true);
    case Takes::off:
      return json(false);
    case Takes::list:
      return list(text);
    case Takes::area:
    case Takes::zone: {
      if (text.starts_with('{') || text.starts_with('[')) return flow(std::string(row.flag), text);
      const bool is_zone = row.takes == Takes::zone;
      const std::size_t at = text.find(is_zone ? ',' : ':');
      const char* const wanted = is_zone ? "the limits inside and outside, '-0.05 mm, 0.1 mm'"
                                         : "a distance, ':' and a share of the area, '0.05 mm: 1 %'";
      if (at == std::string::npos)
        return bad_flag(std::string(row.flag), std::string("must be ") + wanted + ", not " + api::shown_text(text));
      const std::string first = text.substr(0, at), second = text.substr(at + 1);
      return is_zone ? json{first, second} : json{{"distance", first}, {"share", second}};
    }
    case Takes::yaml:
      return flow(std::string(row.flag), text);
    case Takes::text:
      return json(text);
    case Takes::value:
      break;
  }
  return text.starts_with('{') || text.starts_with('[') ? flow(std::string(row.flag), text) : Result<json>(word(text));
}

// --unit, and what --unit-a and --unit-b say otherwise.
Result<Done> set_units(const OptionFlags& flags, json& document) {
  if (!flags.has("--unit") || !(flags.has("--unit-a") || flags.has("--unit-b"))) return Done{};
  const std::string both = flags.text("--unit");
  if (!api::parse_unit(api::trimmed(both)))
    return refused("--unit must be a unit of length (" + api::unit_names() + "), not " + api::shown_text(both), "",
                   "--unit");
  json units{{"candidate", both}, {"baseline", both}};
  if (flags.has("--unit-a")) units["candidate"] = flags.text("--unit-a");
  if (flags.has("--unit-b")) units["baseline"] = flags.text("--unit-b");
  document["units"] = std::move(units);
  return Done{};
}

Error goes_with(const char* flag, const char* others) { return bad_flag(flag, std::string("goes with ") + others); }

}  // namespace

void OptionFlags::declare(CLI::App& app, Command command) {
  command_ = command;
  const unsigned bit = command == Command::compare ? kCompare : kCheck;
  for (const Row& row : kRows) {
    if ((row.commands & bit) == 0) continue;
    Given& given = flags_[row.flag];
    if (row.takes == Takes::on || row.takes == Takes::off) {
      app.add_flag(std::string(row.flag), given.is_on, row.help);
      continue;
    }
    CLI::Option* option = app.add_option(std::string(row.flag), given.text, row.help);
    option->each([&given](const std::string&) { given.is_on = true; });
    if (row.takes == Takes::list) option->join(',');
  }
}

bool OptionFlags::has(std::string_view flag) const {
  const auto found = flags_.find(flag);
  return found != flags_.end() && found->second.is_on;
}

std::vector<std::string> OptionFlags::given() const {
  std::vector<std::string> names;
  for (const Row& row : kRows) {
    if (has(row.flag)) names.emplace_back(row.flag);
  }
  return names;
}

std::vector<std::string> OptionFlags::limits() {
  std::vector<std::string> flags = api::limit_names();
  for (std::string& name : flags) name = flag_of("/" + name);
  return flags;
}

Result<json> OptionFlags::document() const {
  json document = json::object();
  for (const Row& row : kRows) {
    if (!has(row.flag)) continue;
    auto value = value_of(row, flags_.at(row.flag).text);
    if (!value) return value;
    if (row.flag == "--threads" && *value == 0) continue;
    const json::json_pointer place{std::string(row.pointer)}, whole = place.parent_pointer();
    if (!whole.empty() && document.contains(whole) && !document[whole].is_object()) document.erase(whole.back());
    document[place] = *std::move(value);
  }
  if (auto ok = set_units(*this, document); !ok) return ok.error();
  return document;
}

Result<api::Request> OptionFlags::request() const {
  const bool areas = has("--beyond") || has("--quantiles") || has("--mean");
  for (const char* flag : {"--share-tolerance", "--length-tolerance"}) {
    if (has(flag) && !areas) return goes_with(flag, "--beyond, --quantiles or --mean");
  }
  const auto whole = document();
  if (!whole) return whole.error();
  api::ReadRequest read = api::read_request(*whole, command_ == Command::compare ? kCompareFlags : kCheckFlags);
  if (read.mistakes.empty() && command_ == Command::compare && !has_limit(read.request.options)) {
    for (const Row& row : kRows) {
      if (has(row.flag) && api::is_about_limits(row.pointer.substr(1)))
        return bad_flag(std::string(row.flag), "needs " + api::listed(limits(), " or "));
    }
  }
  if (read.mistakes.empty()) return std::move(read.request);
  Error error = api::error_of(read.mistakes);
  const auto name = [](Error& one) {
    one.where = flag_of(one.where);
    one.where = one.where.substr(0, one.where.find_first_of("[."));
    if (!one.message.starts_with("--")) one.message = one.where + ": " + one.message;
    one.part.clear();
  };
  name(error);
  std::ranges::for_each(error.others, name);
  return error;
}

}  // namespace meshgauge::cli
