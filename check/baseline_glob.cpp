#include "check/baseline_glob.h"

#include <algorithm>
#include <filesystem>
#include <vector>

#include "check/manifest/glob.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

std::string with_star(std::string text) {
  if (!text.ends_with('*')) text += '*';  // '**' would match any folders
  return text;
}

// Returns the pattern of the stems of files that `name` matches. If a wildcard stands after or instead of the last
// dot, any dot may be the one before the suffix.
std::string stem_pattern(const std::string& name) {
  if (!is_glob(name)) return name_parts(name, "").stem;
  const std::string stem = name_parts(name, "").stem;
  const std::string suffix = name.substr(stem.size());
  if (!suffix.empty() && !is_glob(suffix) && check_glob(stem).ok()) {
    return suffix == ".gz" ? stem_pattern(stem) : stem;
  }
  return with_star(name.substr(0, name.find_first_of(".*?[")));
}

NameParts patterns_of(std::string_view candidate) {
  const fs::path path(candidate);
  std::vector<std::string> parts(path.begin(), path.end());
  std::string name = std::move(parts.back());
  if (name != "**") {
    parts.pop_back();
  } else {
    parts.back() = name;
    name = "*";
  }
  fs::path dir;
  for (auto part = std::find_if(parts.begin(), parts.end(), is_glob); part != parts.end(); ++part) dir /= *part;
  return {stem_pattern(name), name, dir.string()};
}

std::string literal(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '[' ? "[[]" : std::string(1, c);
  return out;
}

}  // namespace

std::string baseline_glob(std::string_view candidate, std::string_view baseline) {
  return filled(literal(baseline), patterns_of(candidate));
}

}  // namespace meshgauge::check
