#include "check/manifest/expect_setting.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/json_filter.h"
#include "api/refused.h"
#include "api/request.h"
#include "api/suggestion.h"
#include "check/manifest/quantities.h"

namespace meshgauge::check {
namespace {

using Kind = YamlNode::Kind;

constexpr api::Range kVolumeRange{};

template <std::optional<bool> Expectations::*expected>
void read_truth(const Setting& setting, Expectations& expect, Mistakes& mistakes) {
  expect.*expected = read_boolean(setting, mistakes);
}

// Reads a map of min and max, and of `within` unless it is null.
Span read_span(const Setting& setting, const api::Range& range, std::optional<double>* within, Mistakes& mistakes) {
  const YamlNode& map = setting.value;
  constexpr std::string_view kMembers[] = {"min", "max", "within"};
  const std::span known(kMembers, within ? 3 : 2);
  Span span;
  if (map.kind != Kind::map || map.keys.empty()) {
    const std::string what = within ? "must be a map of at least one of within, min, max, not "
                                    : "must be a whole number, or a map of at least one of min, max, not ";
    refuse(setting, what + shown(map), mistakes);
    return span;
  }
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const std::string_view key = map.keys[i].text;
    const std::string name = std::string(setting.key) + "." + std::string(key);
    const Setting member{name, map.items[i]};
    if (key == "min" || key == "max") {
      (key == "min" ? span.min : span.max) = read_within(member, range, mistakes);
    } else if (within && key == "within") {
      const auto share = parse_limit(member.value.text);
      if (member.value.is_text() && share && share->max_diagonal_share) {
        *within = share->max_diagonal_share;
      } else {
        refuse(member, "must be a share of the baseline's volume, as 1 %, not " + shown(member.value), mistakes);
      }
    } else {
      mistakes.add(map.keys[i].place, "unknown key " + api::shown_text(key) + api::suggestion(key, known));
    }
  }
  if (span.min && span.max && *span.min > *span.max) refuse(setting, "has a min above its max", mistakes);
  return span;
}

template <std::optional<Span> Expectations::*expected>
void read_count(const Setting& setting, Expectations& expect, Mistakes& mistakes) {
  if (setting.value.kind != Kind::word) {
    expect.*expected = read_span(setting, api::kCountRange, nullptr, mistakes);
  } else if (const auto number = read_within(setting, api::kCountRange, mistakes)) {
    expect.*expected = Span{number, number};
  }
}

void read_volume(const Setting& setting, Expectations& expect, Mistakes& mistakes) {
  const Span span = read_span(setting, kVolumeRange, &expect.volume_within, mistakes);
  if (span.min || span.max) expect.volume = span;
}

struct ExpectationReader {
  std::string_view key;
  void (*read)(const Setting& setting, Expectations& expect, Mistakes& mistakes);
};

constexpr ExpectationReader kReaders[] = {
    {"watertight", read_truth<&Expectations::watertight>}, {"oriented", read_truth<&Expectations::oriented>},
    {"triangles", read_count<&Expectations::triangles>},   {"degenerate", read_count<&Expectations::degenerate>},
    {"components", read_count<&Expectations::components>}, {"volume", read_volume}};

}  // namespace

void read_expect(const Setting& setting, Draft& draft, Mistakes& mistakes) {
  std::vector<std::string_view> known;
  std::string list;
  for (const ExpectationReader& reader : kReaders) {
    known.push_back(reader.key);
    list += (list.empty() ? "" : ", ") + std::string(reader.key);
  }
  const YamlNode& map = setting.value;
  if (map.kind != Kind::map || map.keys.empty())
    return refuse(setting, "must be a map of at least one of " + list + ", not " + shown(map), mistakes);
  Expectations& expect = draft.gate.expect;
  expect = {};  // those of a gate replace those of the defaults
  for (std::size_t i = 0; i < map.keys.size(); ++i) {
    const std::string_view key = map.keys[i].text;
    const auto* reader =
        std::find_if(std::begin(kReaders), std::end(kReaders), [&](const auto& r) { return r.key == key; });
    if (reader == std::end(kReaders)) {
      mistakes.add(map.keys[i].place, "unknown key " + api::shown_text(key) + api::suggestion(key, known));
      continue;
    }
    const std::string name = std::string(setting.key) + "." + std::string(key);
    reader->read({name, map.items[i]}, expect, mistakes);
  }
}

Result<Expectations> parse_expect(std::string_view text) {
  Mistakes mistakes;
  const auto tree = parse_yaml(text, mistakes);
  Draft draft;
  if (tree) read_expect({"expect", *tree}, draft, mistakes);
  const auto found = std::move(mistakes).sorted();
  if (!found.empty()) return refused(found.front().message);
  return draft.gate.expect;
}

}  // namespace meshgauge::check
