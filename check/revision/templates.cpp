#include "check/revision/templates.h"

#include <span>
#include <utility>

#include "check/manifest/glob.h"
#include "check/manifest/spelling.h"

namespace meshgauge::check {
namespace {

using Parts = std::vector<std::string>;

// Replaces each "[[]", which is a '[' of a name.
std::string with_brackets_as(std::string_view text, std::string part) {
  constexpr std::string_view kBracket = "[[]";
  for (std::size_t at = 0; (at = part.find(kBracket, at)) != std::string::npos; at += text.size())
    part.replace(at, kBracket.size(), text);
  return part;
}

bool is_fixed(const std::string& part) { return !is_glob(with_brackets_as("", part)); }

// How many components stand before the first wildcard. The last one is a file's name.
std::size_t fixed_count(const Parts& parts) {
  std::size_t count = 0;
  while (count + 1 < parts.size() && is_fixed(parts[count])) ++count;
  return count;
}

constexpr std::size_t kMostReadings = 64;  // of a pattern
constexpr std::size_t kToTop = static_cast<std::size_t>(-1);

// The components from the first wildcard on, and how many folders above the fixed one they begin; kToTop: at the top.
struct Rest {
  Parts parts;
  std::size_t up = 0;
};

// Takes ".." after what there is. "**" may stand for no folder: then ".." leaves what is before it.
void leave(Rest rest, std::vector<Rest>& out) {
  if (!rest.parts.empty() && rest.parts.back() == "**") {
    out.push_back(rest);
    rest.parts.pop_back();
  }
  if (rest.parts.empty()) {
    ++rest.up;
  } else {
    rest.parts.pop_back();
  }
  out.push_back(std::move(rest));
}

// Each reading of the pattern without "..": "a/**/../*.stl" is "a/**/*.stl" and "*.stl". If there are too many: one
// that matches more.
std::vector<Rest> rests_of(std::string_view pattern) {
  const Parts parts = components(pattern);
  std::vector<Rest> all{{}};
  for (const std::string& part : std::span(parts).subspan(fixed_count(parts))) {
    if (part == ".") continue;
    std::vector<Rest> next;
    for (Rest& rest : all) {
      if (part == "..") {
        leave(std::move(rest), next);
      } else {
        const bool again = part == "**" && !rest.parts.empty() && rest.parts.back() == "**";
        if (!again) rest.parts.push_back(part);
        next.push_back(std::move(rest));
      }
    }
    if (next.size() > kMostReadings) return {{{"**", parts.back()}, kToTop}};
    all = std::move(next);
  }
  return all;
}

// Splits a path; unlike components() of a pattern, "**" is a name.
Parts names_of(std::string_view path) {
  Parts names;
  while (!path.empty()) {
    const std::size_t slash = path.find('/');
    names.emplace_back(path.substr(0, slash));
    path.remove_prefix(slash == std::string_view::npos ? path.size() : slash + 1);
  }
  return names;
}

std::string key_of(std::span<const std::string> folders) {
  std::string key;
  for (const std::string& folder : folders) key += spelling_key(folder) + "/";
  return key;
}

}  // namespace

std::string folder_in_repository(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

std::string_view name_in_folder(std::string_view path) { return path.substr(path.rfind('/') + 1); }

std::filesystem::path fixed_folder(std::string_view pattern) {
  std::filesystem::path folder = pattern.starts_with('/') ? "/" : "";
  const Parts parts = components(pattern);
  for (const std::string& part : std::span(parts).first(fixed_count(parts))) folder /= with_brackets_as("[", part);
  return folder;
}

void Templates::add(const OpenBaselines& baselines, const std::string& folder) {
  const Parts folders = names_of(folder);
  for (Rest& rest : rests_of(baselines.pattern)) {
    const std::size_t up = rest.up == kToTop ? folders.size() : rest.up;
    if (rest.parts.empty() || up > folders.size()) continue;  // no file's name, or outside
    const auto start = std::span(folders).first(folders.size() - up);
    below_[key_of(start)].push_back({&baselines, std::move(rest.parts)});
  }
  is_listed_ = false;
}

const OpenBaselines* Templates::matching(const std::string& path) {
  if (const std::string folder = folder_in_repository(path); !is_listed_ || folder != folder_) list(folder);
  const std::string name(name_in_folder(path));
  for (const auto& [each, depth] : above_) {
    if (!differences(each->rest.back(), name)) continue;
    const Parts names = names_of(path);
    const auto different = differences(each->rest, std::span(names).subspan(depth));
    if (different && (*different & of_leading_dot) == 0) return each->baselines;
  }
  return nullptr;
}

void Templates::list(const std::string& folder) {
  above_.clear();
  folder_ = folder;
  is_listed_ = true;
  const Parts folders = names_of(folder);
  for (std::size_t depth = 0; depth <= folders.size(); ++depth) {
    const auto found = below_.find(key_of(std::span(folders).first(depth)));
    if (found == below_.end()) continue;
    for (const Template& each : found->second) above_.emplace_back(&each, depth);
  }
}

}  // namespace meshgauge::check
