// Which template of baselines a path of a revision matches.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>
#include <vector>

#include "check/manifest/manifest.h"

namespace meshgauge::check {

// The parts of a path in a repository: "parts/", or empty for its top, and "lid.stl".
std::string folder_in_repository(const std::string& path);
std::string_view name_in_folder(std::string_view path);

// Returns the folder of a pattern's part before the first wildcard. "[[]" is no wildcard, but '['.
std::filesystem::path fixed_folder(std::string_view pattern);

// For one thread. Precondition of all functions: a Utf8Locale lives.
class Templates {
 public:
  // `folder`: where fixed_folder() of its pattern lies in the repository, with a slash at its end, or empty. The object
  // borrows `baselines`.
  void add(const OpenBaselines& baselines, const std::string& folder);

  // Returns the first template that the path matches, also where case or blanks at the ends of names differ; null:
  // none. Takes least where paths of one folder follow each other.
  const OpenBaselines* matching(const std::string& path);

 private:
  struct Template {
    const OpenBaselines* baselines;
    std::vector<std::string> rest;  // components from the first wildcard on
  };

  void list(const std::string& folder);

  std::unordered_map<std::string, std::vector<Template>> below_;  // by the folder, as spelling_key() of each component
  std::string folder_;                                            // of the newest path
  bool is_listed_ = false;
  // Templates whose folders have folder_ below them, and how many components these have.
  std::vector<std::pair<const Template*, std::size_t>> above_;
};

}  // namespace meshgauge::check
