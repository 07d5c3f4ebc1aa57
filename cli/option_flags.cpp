#include "cli/option_flags.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include <CLI/CLI.hpp>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/options/asked_units.h"
#include "api/options/table.h"
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

// A flag whose name or whose value is not as the option has it.
struct OwnFlag {
  std::string_view name;
  std::string_view pointer;  // in the document
  Takes takes;
  std::string_view help;
};

// An option that has some here, for itself or for members of it, has no other flag.
constexpr OwnFlag kOwn[] = {
    {"--max-share-beyond", "/max_share_beyond", Takes::area,
     "The largest share of the area that may be farther than a distance: '0.05 mm: 1 %'"},
    {"--zone", "/zone", Takes::zone,
     "How far the first mesh may be inside and outside of the second, a closed one: '-0.05 mm, 0.1 mm'"},
    {"--fast", "/narrow", Takes::off, "End as soon as the gate is decided, without narrowing the interval"},
    {"--absolute", "/tolerance/absolute", Takes::value, "Stop when upper - lower is at most this"},
    {"--diagonal", "/tolerance/diagonal", Takes::value,
     "Stop when upper - lower is at most this part of the first mesh's diagonal"},
    {"--relative", "/tolerance/relative", Takes::value, "Stop when upper - lower is at most this part of lower"},
    {"--threads", "/threads", Takes::value,
     "At most so many threads for a gate or comparison; 0: as many as there are processors, which gates share"},
    {"--work-items", "/budget/work_items", Takes::value, "Stop after splitting so many pieces"},
    {"--memory-bytes", "/budget/memory_bytes", Takes::value, "Stop when the waiting pieces need more than this"},
    {"--beyond", "/areas/beyond", Takes::list, "Certify the share of the area beyond these distances: 0.05,0.1"},
    {"--quantiles", "/areas/quantiles", Takes::list, "Certify the distances that these shares are within: 0.95,0.99"},
    {"--mean", "/areas/mean", Takes::on, "Certify the mean and the root mean square of the distance"},
    {"--share-tolerance", "/areas/share_tolerance", Takes::value, "Width of a certified share; else 0.001"},
    {"--length-tolerance", "/areas/length_tolerance", Takes::value,
     "Width of a certified quantile or mean, relative to it; else 0.01"},
    {"--sides", "/sides", Takes::on,
     "Certify how far the first mesh reaches outside and inside of the second, which must be closed"},
    {"--statistics", "/statistics", Takes::on, "Sample mean, RMS, percentiles and a histogram as well"},
    {"--samples", "/statistics/samples", Takes::value,
     "Points sampled in each direction, 1000 to 1000000; else 100000"},
    {"--seed", "/statistics/seed", Takes::value, "Another one samples other points; else 1"},
    {"--unit", "/units", Takes::text, "The unit of both files, whatever they say themselves: um, mm, cm, m, in, ft"},
    {"--unit-a", "/units/candidate", Takes::text, "The unit of the first file"},
    {"--unit-b", "/units/baseline", Takes::text, "The unit of the second file"}};

struct Flag {
  std::string name;
  std::string pointer;
  Takes takes = Takes::value;
  std::string help;
  bool in_gates = true;  // false: `check` does not have it
};

// Whether the pointer is `whole`, or below it.
bool is_in(std::string_view pointer, std::string_view whole) {
  return pointer.starts_with(whole) && (pointer.size() == whole.size() || pointer[whole.size()] == '/');
}

Takes takes_of(api::OptionKind kind) {
  switch (kind) {
    case api::OptionKind::toggle:
      return Takes::on;
    case api::OptionKind::shape:
      return Takes::yaml;
    case api::OptionKind::length:
    case api::OptionKind::limit:
    case api::OptionKind::count:
    case api::OptionKind::choice:
    case api::OptionKind::time:
      break;
  }
  return Takes::value;
}

// Returns the option's line, with what may be given.
std::string help_of(const api::Option& option) {
  std::string help(option.help);
  api::replace_all(help, "{a}", "the first mesh");
  api::replace_all(help, "{b}", "the second mesh");
  if (option.words) return help + ": " + api::listed(option.words());
  if (!option.example.empty()) return help + ": '" + std::string(option.example) + "'";
  if (option.kind == api::OptionKind::count && !option.usual.empty()) help.append("; else ").append(option.usual);
  return help;
}

void add_flags(const api::Option& option, std::vector<Flag>& flags) {
  const bool in_gates = (option.surfaces & api::Surface::manifest) != 0;
  const std::string pointer = "/" + std::string(option.key);
  const std::size_t before = flags.size();
  for (const OwnFlag& own : kOwn) {
    if (is_in(own.pointer, pointer))
      flags.push_back({std::string(own.name), std::string(own.pointer), own.takes, std::string(own.help), in_gates});
  }
  if (flags.size() > before) return;
  std::string name = "--" + std::string(option.key);
  std::ranges::replace(name, '_', '-');
  flags.push_back({std::move(name), pointer, takes_of(option.kind), help_of(option), in_gates});
}

const std::vector<Flag>& all_flags() {
  static const std::vector<Flag> kFlags = [] {
    std::vector<Flag> flags;
    for (const api::Option* option : api::all_options()) {
      if ((option->surfaces & api::Surface::flags) != 0) add_flags(*option, flags);
    }
    return flags;
  }();
  return kFlags;
}

// The flag of a pointer, with what is below it: "--regions[0].box".
std::string flag_of(std::string_view pointer) {
  const Flag* best = nullptr;
  for (const Flag& flag : all_flags()) {
    if (is_in(pointer, flag.pointer) && (!best || flag.pointer.size() > best->pointer.size())) best = &flag;
  }
  if (best) {
    const std::string below = api::dotted(pointer.substr(best->pointer.size()));
    return best->name + (below.empty() || below.starts_with('[') ? "" : ".") + below;
  }
  const auto part =
      std::ranges::find_if(all_flags(), [&](const Flag& flag) { return flag.pointer.starts_with(pointer); });
  return part == all_flags().end() ? api::dotted(pointer) : part->name;
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

Result<json> value_of(const Flag& flag, const std::string& text) {
  switch (flag.takes) {
    case Takes::on:
      return json(true);
    case Takes::off:
      return json(false);
    case Takes::list:
      return list(text);
    case Takes::area:
    case Takes::zone: {
      if (text.starts_with('{') || text.starts_with('[')) return flow(flag.name, text);
      const bool is_zone = flag.takes == Takes::zone;
      const std::size_t at = text.find(is_zone ? ',' : ':');
      const char* const wanted = is_zone ? "the limits inside and outside, '-0.05 mm, 0.1 mm'"
                                         : "a distance, ':' and a share of the area, '0.05 mm: 1 %'";
      if (at == std::string::npos)
        return bad_flag(flag.name, std::string("must be ") + wanted + ", not " + api::shown_text(text));
      const std::string first = text.substr(0, at), second = text.substr(at + 1);
      return is_zone ? json{first, second} : json{{"distance", first}, {"share", second}};
    }
    case Takes::yaml:
      return flow(flag.name, text);
    case Takes::text:
      return json(text);
    case Takes::value:
      break;
  }
  return text.starts_with('{') || text.starts_with('[') ? flow(flag.name, text) : Result<json>(word(text));
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
  for (const Flag& flag : all_flags()) {
    if (command == Command::check && !flag.in_gates) continue;
    Given& given = flags_[flag.name];
    if (flag.takes == Takes::on || flag.takes == Takes::off) {
      app.add_flag(flag.name, given.is_on, flag.help);
      continue;
    }
    CLI::Option* option = app.add_option(flag.name, given.text, flag.help);
    option->each([&given](const std::string&) { given.is_on = true; });
    if (flag.takes == Takes::list) option->join(',');
  }
}

bool OptionFlags::has(std::string_view flag) const {
  const auto found = flags_.find(flag);
  return found != flags_.end() && found->second.is_on;
}

std::vector<std::string> OptionFlags::given() const {
  std::vector<std::string> names;
  for (const Flag& flag : all_flags()) {
    if (has(flag.name)) names.push_back(flag.name);
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
  for (const Flag& flag : all_flags()) {
    if (!has(flag.name)) continue;
    auto value = value_of(flag, flags_.at(flag.name).text);
    if (!value) return value;
    if (flag.name == "--threads" && *value == 0) continue;
    const json::json_pointer place(flag.pointer), whole = place.parent_pointer();
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
    for (const Flag& flag : all_flags()) {
      if (has(flag.name) && api::is_about_limits(std::string_view(flag.pointer).substr(1)))
        return bad_flag(flag.name, "needs " + api::listed(limits(), " or "));
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
