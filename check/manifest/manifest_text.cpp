#include "check/manifest/manifest_text.h"

#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/suggestion.h"
#include "api/base/text.h"
#include "api/base/utf8.h"
#include "api/options/names.h"
#include "api/options/request.h"
#include "check/manifest/glob.h"
#include "check/manifest/naming.h"
#include "check/manifest/yaml_json.h"
#include "check/manifest/yaml_tree.h"

namespace meshgauge::check {
namespace {

using Kind = YamlNode::Kind;

constexpr std::string_view kTop[] = {"version", "defaults", "gates"};
constexpr std::string_view kOwn[] = {"name", "candidate", "baseline"};  // keys of a gate that are not settings
constexpr std::string_view kOfGates[] = {"cloud", "on_fail", "unmatched_baselines"};
constexpr api::Name<bool> kOnFail[] = {{false, "fail"}, {true, "warn"}};                 // values of Gate::warn_only
constexpr api::Name<bool> kUnmatchedBaselines[] = {{false, "error"}, {true, "ignore"}};  // of Entry::unmatched_ignored
constexpr std::string_view kExample = "version: 1, then gates: with a list of '- name: ...'";

// Keys from elsewhere: the API, flags, YAML.
struct Foreign {
  std::string_view key;
  std::string_view advice;
  std::string_view meant;  // the manifest's key of that meaning; empty: there is none
};
constexpr Foreign kForeign[] = {
    {"a", "the mesh that is checked is 'candidate'", "candidate"},
    {"b", "the mesh to compare with is 'baseline'", "baseline"},
    {"limit", "the limit is 'max_distance'", "max_distance"},
    {"gate", "write 'max_distance' here, and its unit behind the number", "max_distance"},
    {"max_diagonal_share", "a share of the diagonal is 'max_distance: 0.5 %'", "max_distance"},
    {"unit", "the unit of both meshes is 'units: mm', that of the limit stands behind its number", "units"},
    {"timeout_ms", "the unit stands behind the number: 'timeout: 500 ms'", "timeout"},
    {"warn_only", "write 'on_fail: warn'", "on_fail"},
    {"<<", "maps cannot be merged: what gates share stands under 'defaults'", ""}};

bool holds(std::span<const std::string_view> words, std::string_view word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// The keys of a gate and of the defaults: those of a request, then those that only a gate has.
const std::vector<std::string_view>& settings() {
  static const std::vector<std::string_view> kSettings = [] {
    std::vector<std::string_view> keys = api::options_of(kManifest);
    keys.insert(keys.end(), std::begin(kOfGates), std::end(kOfGates));
    return keys;
  }();
  return kSettings;
}

const Foreign* foreign_key(std::string_view key) {
  const auto found = std::find_if(std::begin(kForeign), std::end(kForeign), [&](auto& f) { return f.key == key; });
  return found == std::end(kForeign) ? nullptr : found;
}

std::string unknown_key(std::string_view key, std::span<const std::string_view> known) {
  const std::string shown = api::shown_text(key);
  if (holds(kOwn, key)) return "key " + shown + " belongs to a gate";
  if (holds(settings(), key)) return "key " + shown + " belongs to a gate or under 'defaults'";
  const Foreign* foreign = holds(known, "name") ? foreign_key(key) : nullptr;
  return "unknown key " + shown + (foreign ? ": " + std::string(foreign->advice) : api::suggestion(key, known));
}

// Whether the key is there under another name, which is already a mistake.
bool is_misnamed(const YamlNode& map, std::string_view key) {
  return std::any_of(map.keys.begin(), map.keys.end(), [&](const Written& written) {
    if (holds(kOwn, written.text) || holds(settings(), written.text)) return false;
    const Foreign* foreign = foreign_key(written.text);
    return foreign ? foreign->meant == key : !api::nearest(written.text, std::span(&key, 1)).empty();
  });
}

// Adds a mistake for each key that is neither a setting nor one of `own`.
void check_keys(const YamlNode& map, std::span<const std::string_view> own, Mistakes& mistakes) {
  std::vector<std::string_view> known(own.begin(), own.end());
  known.insert(known.end(), settings().begin(), settings().end());
  for (const Written& key : map.keys) {
    if (!holds(known, key.text)) mistakes.add(key.place, unknown_key(key.text, known));
  }
}

void read_of_gates(const nlohmann::json& settings, api::Reading& reading, Entry& entry) {
  const auto value = [&](const char* key) { return settings.value(key, nlohmann::json()); };
  if (settings.contains("cloud")) entry.gate.cloud = reading.boolean(value("cloud"), "/cloud").value_or(false);
  if (settings.contains("on_fail"))
    entry.gate.warn_only = reading.name(kOnFail, value("on_fail"), "/on_fail").value_or(false);
  if (settings.contains("unmatched_baselines"))
    entry.unmatched_ignored =
        reading.name(kUnmatchedBaselines, value("unmatched_baselines"), "/unmatched_baselines").value_or(false);
}

nlohmann::json settings_of(const YamlNode& map) {
  auto json = nlohmann::json::object();
  for (const std::string_view key : settings()) {
    if (const YamlNode* const node = find(map, key)) json[std::string(key)] = json_of(*node);
  }
  return json;
}

nlohmann::json request_of(nlohmann::json settings) {
  for (const std::string_view key : kOfGates) settings.erase(std::string(key));
  return settings;
}

std::string first_of(std::string_view pointer) {
  const std::size_t end = pointer.find('/', 1);
  return pointer.empty() ? std::string()
                         : std::string(pointer.substr(1, end == std::string_view::npos ? end : end - 1));
}

// The defaults: what of them can be read.
struct Defaults {
  const YamlNode* map = nullptr;  // null: there are none
  nlohmann::json settings = nlohmann::json::object();
  std::vector<std::string> given{};  // the keys, also of what cannot be read

  bool has(std::string_view key) const { return std::find(given.begin(), given.end(), key) != given.end(); }
};

Defaults read_defaults(const YamlNode* node, Mistakes& mistakes) {
  Defaults defaults;
  if (!node) return defaults;
  if (node->kind != Kind::map) {
    mistakes.add(node->place, "defaults must be a map of settings, not " + shown(*node));
    return defaults;
  }
  check_keys(*node, {}, mistakes);
  defaults.map = node;
  defaults.settings = settings_of(*node);
  for (const auto& [key, value] : defaults.settings.items()) defaults.given.push_back(key);
  api::Reading reading(kManifest);
  Entry nothing;
  read_of_gates(defaults.settings, reading, nothing);
  auto found = api::mistakes_in_part(request_of(defaults.settings), kManifest);
  for (const api::RequestMistake& one : reading.told()) found.push_back(one);
  for (const api::RequestMistake& one : found) {
    mistakes.add(place_of(*node, one.pointer, one.of_key), one.message);
    defaults.settings.erase(first_of(one.pointer));  // it is told once, and left out of the gates
  }
  return defaults;
}

// Reads the settings of a gate: its own, and those of the defaults that it has not.
void read_settings(const YamlNode& gate, const Defaults& defaults, Entry& entry, Mistakes& mistakes) {
  const nlohmann::json own = settings_of(gate);
  nlohmann::json all = defaults.settings;
  // `points` of the defaults is for gates of that strategy.
  if (own.contains("strategy") && own["strategy"] != "n_point") all.erase("points");
  all.update(own);
  api::Reading reading(kManifest);
  read_of_gates(all, reading, entry);
  api::ReadRequest read = api::read_request(request_of(all), kManifest);
  entry.gate.request = std::move(read.request);
  for (const api::RequestMistake& one : reading.told()) read.mistakes.push_back(one);
  for (const api::RequestMistake& one : read.mistakes) {
    const bool is_own = own.contains(first_of(one.pointer)) || !defaults.map;
    mistakes.add(place_of(is_own ? gate : *defaults.map, one.pointer, one.of_key), one.message);
  }
}

// Returns an empty text if the node is not a usable text.
Written read_text(std::string_view key, const YamlNode& node, std::size_t max_bytes, Mistakes& mistakes) {
  const auto refuse = [&](const std::string& what) {
    mistakes.add(node.place, std::string(key) + " " + what);
    return Written{"", node.place};
  };
  if (!node.is_text()) {
    return refuse("must be a text, not " + shown(node) + (node.kind == Kind::none ? "" : "; put it in quotes"));
  }
  if (is_bare_value(node)) return refuse("must be a text: put " + shown(node) + " in quotes");
  if (node.text.empty()) return refuse("must not be empty");
  if (node.text.size() > max_bytes) return refuse("must not be longer than " + std::to_string(max_bytes) + " bytes");
  if (find_control(node.text) != std::string::npos || !is_utf8(node.text)) {
    return refuse("must be on one line, without control characters");
  }
  return {node.text, node.place};
}

void empty_if(Written& written, const char* key, const Result<Done>& checked, Mistakes& mistakes) {
  if (checked || written.text.empty()) return;
  mistakes.add(written.place, std::string(key) + " " + checked.error().message);
  written.text.clear();
}

Result<Done> check_candidate(const std::string& text) {
  if (has_placeholder(text)) {
    return refused(
        "must not have '{': placeholders stand in name and baseline, alternatives are gates of their own; for "
        "the character itself write '[{]'");
  }
  return check_glob(text);
}

Result<Done> check_baseline(const std::string& text) {
  if (text.find_first_of("*?") == std::string::npos) return check_template(text);
  return refused("must be one file for each candidate, not a glob: write {stem}, {name} or {dir}");
}

// Returns "gate 'bracket'", or a description without the name.
std::string subject(const Entry& entry) {
  return entry.name.text.empty() ? "the gate" : "gate " + api::shown_text(entry.name.text);
}

Entry read_entry(const YamlNode& node, const Defaults& defaults, Mistakes& mistakes) {
  check_keys(node, kOwn, mistakes);
  Entry entry;
  entry.place = node.place;
  entry.gate.line = node.place.line;
  read_settings(node, defaults, entry, mistakes);
  const auto text = [&](const char* key, std::size_t max_bytes) {
    const YamlNode* value = find(node, key);
    return value ? read_text(key, *value, max_bytes, mistakes) : Written{};
  };
  entry.name = text("name", kMaxNameBytes);
  entry.candidate = text("candidate", kMaxPathBytes);
  entry.baseline = text("baseline", kMaxPathBytes);
  empty_if(entry.name, "name", check_template(entry.name.text), mistakes);
  empty_if(entry.candidate, "candidate", check_candidate(entry.candidate.text), mistakes);
  empty_if(entry.baseline, "baseline", check_baseline(entry.baseline.text), mistakes);
  for (const std::string_view key : kOwn) {
    if (!find(node, key) && !is_misnamed(node, key))
      mistakes.add(node.place,
                   subject(entry) + " has no " + std::string(key) + ": add '" + std::string(key) + ": ...'");
  }
  const auto is_there = [&](std::string_view limit) {
    return find(node, limit) || defaults.has(limit) || is_misnamed(node, limit);
  };
  const std::vector<std::string> limits = api::limit_names();
  if (std::ranges::none_of(limits, is_there)) {
    mistakes.add(node.place, subject(entry) +
                                 " has no max_distance: give one here or under 'defaults', as 0.05 mm or 0.5 %; or " +
                                 api::listed(std::span(limits).subspan(1), " or "));
  }
  return entry;
}

std::vector<Entry> read_gates(const YamlNode& list, const Defaults& defaults, Mistakes& mistakes) {
  std::vector<Entry> entries;
  if (list.kind != Kind::list || list.items.empty()) {
    const bool none = list.kind == Kind::list || list.kind == Kind::none;
    mistakes.add(list.place, none ? "gates is empty, so nothing would be checked: add a gate, '- name: ...'"
                                  : "gates must be a list of '- name: ...', not " + shown(list));
    return entries;
  }
  for (const YamlNode& item : list.items) {
    if (item.kind == Kind::map) {
      entries.push_back(read_entry(item, defaults, mistakes));
    } else {
      mistakes.add(item.place, "a gate must be a map with name, candidate and baseline, not " + shown(item));
    }
  }
  return entries;
}

void check_version(const YamlNode* version, Mistakes& mistakes) {
  if (!version) return mistakes.add({1, 1}, "version is missing: write 'version: 1' at the top");
  if (version->kind == Kind::word && version->text == "1") return;
  mistakes.add(version->place, "version must be 1, without quotes, not " + shown(*version));
}

}  // namespace

std::vector<Entry> read_manifest(std::string_view text, Mistakes& mistakes) {
  const auto root = parse_yaml(text, mistakes);
  if (!root) return {};
  if (root->kind != Kind::map) {
    const std::string is = root->kind == Kind::none ? "the manifest is empty" : "the manifest is " + shown(*root);
    mistakes.add({1, 1}, is + "; it must be a map: " + std::string(kExample));
    return {};
  }
  for (const Written& key : root->keys) {
    if (!holds(kTop, key.text)) mistakes.add(key.place, unknown_key(key.text, kTop));
  }
  check_version(find(*root, "version"), mistakes);
  const Defaults defaults = read_defaults(find(*root, "defaults"), mistakes);
  const YamlNode* gates = find(*root, "gates");
  if (!gates) mistakes.add({1, 1}, "gates is missing: list what to check, each with '- name: ...'");
  return gates ? read_gates(*gates, defaults, mistakes) : std::vector<Entry>{};
}

}  // namespace meshgauge::check
