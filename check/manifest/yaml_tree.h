// A YAML document as a small tree in which everything knows where it stands. yaml-cpp reads it, event by event; its own
// tree keeps the last of two keys that are the same, and follows aliases, of which a few lines can make billions.
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
  std::string text;             // of a word or a quoted text
  std::vector<Written> keys;    // of a map
  std::vector<YamlNode> items;  // of a list, or the values of `keys`

  bool is_text() const { return kind == Kind::word || kind == Kind::quoted; }
};

// The one document of a file; an empty file holds `none`. Mistakes: a key that stands twice in a map, which then has it
// twice. Mistakes after which nothing is returned: what is not YAML, in UTF-8; more than the limits above; aliases,
// tags and keys that are no texts, which nothing here needs.
std::optional<YamlNode> parse_yaml(std::string_view text, Mistakes& mistakes);

}  // namespace meshgauge::check
