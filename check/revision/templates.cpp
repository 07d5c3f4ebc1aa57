#include "check/revision/templates.h"

#include <span>
#include <utility>

#include "check/manifest/glob.h"
#include "check/manifest/spelling.h"

namespace meshgauge::check {
namespace {

// How many components stand before the first wildcard. The last one is a file's name.
std::size_t fixed_count(const std::vector<std::string>& parts) {
  std::size_t count = 0;
  while (count + 1 < parts.size() && !is_glob(parts[count])) ++count;
  return count;
}

// The components from the first wildcard on. They may match more than the pattern: "**/.." is "**".
std::vector<std::string> rest_of(std::string_view pattern) {
  const std::vector<std::string> parts = components(pattern);
  std::vector<std::string> rest;
  for (const std::string& part : std::span(parts).subspan(fixed_count(parts))) {
    const bool leaves = part == ".." && !rest.empty() && rest.back() != "**";
    if (leaves) rest.pop_back();
    if (part != "." && part != "..") rest.push_back(part);
  }
  return rest;
}

}  // namespace

std::string folder_in_repository(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string::npos ? "" : path.substr(0, slash + 1);
}

std::string_view name_in_folder(std::string_view path) { return path.substr(path.rfind('/') + 1); }

std::filesystem::path fixed_folder(std::string_view pattern) {
  std::filesystem::path folder = pattern.starts_with('/') ? "/" : "";
  const std::vector<std::string> parts = components(pattern);
  for (const std::string& part : std::span(parts).first(fixed_count(parts))) folder /= part;
  return folder;
}

void Templates::add(const OpenBaselines& baselines, const std::string& folder) {
  std::vector<std::string> rest = rest_of(baselines.pattern);
  if (rest.empty()) return;  // it is no file's name
  below_[spelling_key(folder)].push_back({&baselines, std::move(rest)});
  is_listed_ = false;
}

const OpenBaselines* Templates::matching(const std::string& path) {
  if (const std::string folder = folder_in_repository(path); !is_listed_ || folder != folder_) list(folder);
  const std::string name(name_in_folder(path));
  for (const auto& [each, depth] : above_) {
    if (!differences(each->rest.back(), name)) continue;
    const std::vector<std::string> parts = components(path);
    const auto different = differences(each->rest, std::span(parts).subspan(depth));
    if (different && (*different & of_leading_dot) == 0) return each->baselines;
  }
  return nullptr;
}

void Templates::list(const std::string& folder) {
  above_.clear();
  folder_ = folder;
  is_listed_ = true;
  std::size_t depth = 0;
  for (std::size_t end = 0; end != std::string::npos; ++depth) {
    const auto found = below_.find(spelling_key(folder.substr(0, end)));
    if (found != below_.end()) {
      for (const Template& each : found->second) above_.emplace_back(&each, depth);
    }
    const std::size_t slash = folder.find('/', end);
    end = slash == std::string::npos ? slash : slash + 1;
  }
}

}  // namespace meshgauge::check
