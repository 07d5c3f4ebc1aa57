// A YAML document as a tree in which every node has its place. Built from yaml-cpp's events, because its own tree
// keeps the last of duplicate keys and expands aliases, a few of which can produce billions of nodes.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check/manifest/mistake.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxYamlBytes = std::size_t{1} << 20;
inline constexpr std::size_t kMaxYamlDepth = 16;
inline constexpr std::size_t kMaxYamlNodes = 100'000;

struct YamlNode {
  enum class Kind { none, word, quoted, list, map };  // none: "key:" or null; word: without quotes, may be a number

  Kind kind = Kind::none;
  Place place;                  // of "key:" without a value: the key's
  std::string text;             // value of a scalar
  std::vector<Written> keys;    // keys of a map
  std::vector<YamlNode> items;  // items of a list, or the values of `keys`

  bool is_text() const { return kind == Kind::word || kind == Kind::quoted; }
};

// Parses the one document of a file; an empty file gives `none`. Adds a mistake for a duplicate key, and keeps both.
// Returns nullopt after a mistake of these kinds: not YAML or not UTF-8, above a limit, aliases, tags, keys that are
// not text.
std::optional<YamlNode> parse_yaml(std::string_view text, Mistakes& mistakes);

}  // namespace meshgauge::check
