// The settings of a gate in a manifest: the keys that stand in a gate or under `defaults`.
#pragma once

#include <span>
#include <string_view>

#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "check/manifest/yaml_tree.h"

namespace meshgauge::check {

// A gate's settings while they are read: those of `defaults` first, then its own over them.
struct Draft {
  Gate gate;
  bool unmatched_ignored = false;  // a baseline without a candidate is no mistake
  bool limit_given = false;        // also when it could not be read: said once is enough
  bool own_strategy = false;
  bool own_points = false;
  Place points;  // line 0: not given
};

// A value and the key that it stands behind.
struct Setting {
  std::string_view key;
  const YamlNode& value;
};

struct SettingReader {
  std::string_view key;
  void (*read)(const Setting& setting, Draft& draft, Mistakes& mistakes);
};

std::span<const SettingReader> setting_readers();

// What is wrong between settings, once all are read.
void check_settings(const Draft& draft, Mistakes& mistakes);

// "'x'", "a list", "a map", "empty": for "must be ..., not ...".
std::string shown(const YamlNode& node);

// A number or true, by YAML's rules: what is meant as a text has to stand in quotes.
bool is_bare_value(const YamlNode& node);

}  // namespace meshgauge::check
