// Settings of a gate in a manifest: the keys of a gate or of `defaults`.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/request.h"
#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "check/manifest/yaml_tree.h"

namespace meshgauge::check {

// Settings of a gate while they are read: `defaults` first, then the gate's own.
struct Draft {
  Gate gate;
  bool unmatched_ignored = false;  // a baseline without a candidate is not a mistake
  bool limit_given = false;        // also set when a limit could not be read, so that it is reported once
  Place beside;                    // of max_share_beyond, zone, uncertainty or regions; line 0: not given
  bool own_strategy = false;
  bool own_points = false;
  Place points;  // line 0: not given
};

// A value with its key.
struct Setting {
  std::string_view key;
  const YamlNode& value;
};

struct SettingReader {
  std::string_view key;
  void (*read)(const Setting& setting, Draft& draft, Mistakes& mistakes);
};

std::span<const SettingReader> setting_readers();

// Adds the mistake "KEY what".
void refuse(const Setting& setting, const std::string& what, Mistakes& mistakes);

// Read one value, or add a mistake and return nullopt.
std::optional<double> read_within(const Setting& setting, const api::Range& range, Mistakes& mistakes);
std::optional<bool> read_boolean(const Setting& setting, Mistakes& mistakes);

// Adds mistakes about combinations of settings. Call it when all are read.
void check_settings(const Draft& draft, Mistakes& mistakes);

// Parses an alignment as the flag `name`, a word or a map as in a manifest: "{principal_axes: true}".
Result<std::optional<AlignOptions>> parse_align(std::string_view text, const std::string& name);

// Describes a node for "must be ..., not ...": "'x'", "a list", "a map", "empty".
std::string shown(const YamlNode& node);

// Whether YAML reads the node as a number or a boolean; a text that looks like one must be quoted.
bool is_bare_value(const YamlNode& node);

}  // namespace meshgauge::check
