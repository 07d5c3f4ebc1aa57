#include "check/manifest/first_manifest.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"
#include "api/formats/detect.h"
#include "check/files.h"
#include "check/manifest/glob.h"
#include "check/manifest/naming.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

using Names = std::set<std::string>;
using Folders = std::map<std::string, Names>;  // folder below the manifest's, or "" -> its meshes

// Words in the names of folders that hold what is wanted.
constexpr std::string_view kWanted[] = {"baseline", "reference", "golden", "expected", "nominal", "master", "original"};
constexpr std::string_view kRef[] = {"ref", "refs", "base", "gold"};  // whole names

bool is_for_baselines(const std::string& name) {
  const std::string folder = api::lower_case(name);
  return std::ranges::any_of(kWanted, [&](auto word) { return folder.find(word) != std::string::npos; }) ||
         std::ranges::find(kRef, folder) != std::end(kRef);
}

std::string suffix_as_written(const std::string& name) { return name.substr(name_parts(name, "").stem.size()); }

Result<Folders> meshes_below(const fs::path& folder) {
  Folders found;
  std::size_t looked_at = 0;
  std::error_code failed, none;
  const auto look = [&](const fs::path& place, const std::string& below, auto visit_folder) {
    for (fs::directory_iterator it(place, failed), end; !failed && it != end; it.increment(failed)) {
      if (++looked_at > kMaxGlobEntries) return false;
      std::string name = it->path().filename().string();
      if (name.starts_with('.')) continue;
      if (it->is_directory(none))
        visit_folder(std::move(name));
      else if (it->is_regular_file(none) && api::format_by_name(name))
        found[below].insert(std::move(name));
    }
    return true;
  };
  Names folders;
  bool all = look(folder, "", [&](std::string name) { folders.insert(std::move(name)); });
  if (failed) return refused("the folder " + shown_path(folder) + " cannot be read: " + failed.message());
  for (const std::string& name : folders) {
    if (all) all = look(folder / name, name, [](const std::string&) {});
    failed.clear();  // a folder that cannot be read has no meshes for this user
  }
  if (!all)
    return refused("the folder " + shown_path(folder) + " holds more than " + std::to_string(kMaxGlobEntries) +
                   " files: name a smaller one");
  return found;
}

Names stems_of(const Names& files) {
  Names stems;
  for (const std::string& file : files) stems.insert(name_parts(file, "").stem);
  return stems;
}

std::size_t in_common(const Names& x, const Names& y) {
  return static_cast<std::size_t>(std::ranges::count_if(x, [&](const std::string& one) { return y.contains(one); }));
}

// What the manifest can say in a template, where braces and wildcards have a meaning.
bool is_plain_path(const std::string& text) {
  return text.find_first_of("{}*?") == std::string::npos && is_utf8(text) && find_control(text) == std::string::npos;
}

struct FolderPair {
  std::string candidates, baselines;
  bool sure = false;  // the names of the folders say which is which
};

std::optional<FolderPair> pair_of(const Folders& folders) {
  std::optional<FolderPair> best;
  std::size_t most = 0;
  std::map<std::string, Names> stems;
  for (const auto& [name, files] : folders) stems[name] = stems_of(files);
  for (auto x = stems.begin(); x != stems.end(); ++x) {
    for (auto y = std::next(x); y != stems.end(); ++y) {
      const bool x_wanted = is_for_baselines(x->first), y_wanted = is_for_baselines(y->first);
      const std::size_t common = in_common(x->second, y->second);
      const std::size_t worth = 2 * common + (x_wanted != y_wanted ? 1 : 0);
      const bool swapped = x_wanted && !y_wanted;
      const FolderPair pair{swapped ? y->first : x->first, swapped ? x->first : y->first, x_wanted != y_wanted};
      if (worth <= most || pair.baselines.empty() || !is_plain_path(pair.baselines)) continue;
      most = worth;
      best = pair;
    }
  }
  return best;
}

// Returns a pattern of exactly these suffixes, which differ only in case: ".[sS][tT]l" for .stl, .STl.
std::string suffix_pattern(const Names& suffixes) {
  std::string pattern;
  for (std::size_t i = 0; i < suffixes.begin()->size(); ++i) {
    std::set<char, std::greater<>> letters;
    for (const std::string& suffix : suffixes) letters.insert(suffix[i]);
    const std::string all(letters.begin(), letters.end());
    pattern += all.size() == 1 ? all : "[" + all + "]";
  }
  return pattern;
}

// In double quotes, for YAML.
std::string in_yaml(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

// Without a meaning for glob().
std::string plain_in_glob(std::string_view text) {
  std::string out;
  for (const char c : text)
    out += std::string_view("*?[{").find(c) == std::string_view::npos ? std::string(1, c) : std::string{'[', c, ']'};
  return out;
}

std::string in_folder(const std::string& folder, const std::string& name) {
  return folder.empty() ? name : folder + "/" + name;
}

// The template of names that most of the baselines have: as their candidates, or with another suffix.
std::string baseline_name(const Names& candidates, const Names& baselines) {
  Names suffixes;
  for (const std::string& file : baselines) suffixes.insert(suffix_as_written(file));
  std::string best = "{name}";
  std::size_t most = in_common(candidates, baselines);
  for (const std::string& suffix : suffixes) {
    if (!is_plain_path(suffix)) continue;
    const auto there = [&](const std::string& file) { return baselines.contains(name_parts(file, "").stem + suffix); };
    const auto count = static_cast<std::size_t>(std::ranges::count_if(candidates, there));
    if (count > most) best = "{stem}" + suffix, most = count;
  }
  return best;
}

class ManifestWriter {
 public:
  ManifestWriter(const Folders& folders, const std::optional<FolderPair>& pair) : folders_(folders), pair_(pair) {
    for (const auto& [folder, files] : folders_) {
      if (is_candidates(folder)) ++several_;
    }
    if (pair_) new_baselines_ = pair_->baselines;
    while (!pair_ && folders_.contains(new_baselines_)) new_baselines_ += "_new";
  }

  std::string entries() {
    std::string text;
    const std::string name = name_template();
    for (const auto& [folder, files] : folders_) {
      if (!is_candidates(folder)) continue;
      std::map<std::string, std::pair<Names, Names>> by_suffix;  // in lower case -> suffixes, files
      for (const std::string& file : files) {
        auto& [suffixes, same] = by_suffix[suffix_of(file)];
        suffixes.insert(suffix_as_written(file));
        same.insert(file);
      }
      for (const auto& [suffix, group] : by_suffix) {
        const std::string own = name == kWithFolder ? in_folder(folder, "{name}") : name;
        text += "  - name: " + in_yaml(own) +
                "\n    candidate: " + in_yaml(in_folder(plain_in_glob(folder), "*" + suffix_pattern(group.first))) +
                "\n    baseline: " + in_yaml(baseline_of(folder, group.second)) + "\n";
      }
    }
    return text;
  }

  bool makes_baselines() const { return makes_baselines_; }
  std::vector<std::string> left_out;

 private:
  static constexpr const char* kWithFolder = "";

  bool is_candidates(const std::string& folder) {
    if (pair_ && folder == pair_->baselines) return false;
    if (is_utf8(folder) && find_control(folder) == std::string::npos) return true;
    if (said_.insert(folder).second)
      left_out.push_back("the folder " + shown_path(folder) +
                         " is left out, since a manifest cannot name it: rename it");
    return false;
  }

  std::string baseline_of(const std::string& folder, const Names& files) {
    if (pair_ && folder == pair_->candidates)
      return pair_->baselines + "/" + baseline_name(files, folders_.at(pair_->baselines));
    makes_baselines_ = true;
    const std::string apart = pair_ && folder.empty() ? "here" : pair_ || several_ > 1 ? folder : "";
    const bool named = !apart.empty() && is_plain_path(apart);
    return (named ? in_folder(new_baselines_, apart) : new_baselines_) + "/{name}";
  }

  // Names are unique in a manifest.
  std::string name_template() {
    Names stems, names;
    std::size_t count = 0;
    for (const auto& [folder, files] : folders_) {
      if (!is_candidates(folder)) continue;
      count += files.size();
      names.insert(files.begin(), files.end());
      for (const std::string& file : files) stems.insert(name_parts(file, "").stem);
    }
    return stems.size() == count ? "{stem}" : names.size() == count ? "{name}" : kWithFolder;
  }

  const Folders& folders_;
  const std::optional<FolderPair>& pair_;
  std::size_t several_ = 0;
  std::string new_baselines_ = "baselines";
  bool makes_baselines_ = false;
  Names said_;
};

}  // namespace

Result<FirstManifest> first_manifest(const fs::path& folder, const std::string& limit) {
  auto folders = meshes_below(folder);
  if (!folders) return folders.error();
  if (folders->empty())
    return refused("no mesh file is in " + shown_path(folder) +
                   " or in the folders directly in it: name the folder that holds them");
  const auto pair = pair_of(*folders);
  ManifestWriter writer(*folders, pair);
  const std::string entries = writer.entries();
  if (entries.empty()) return refused(writer.left_out.front());
  std::string text =
      "# Which meshes have to be how close to their baselines. Run: meshgauge check gates.yaml\nversion: 1\ndefaults:\n"
      "  # Look at this limit: how far a mesh may be from its baseline. A length with its unit, as 0.05 mm, or a "
      "share\n"
      "  # of the diagonal of the baseline, as 0.1 %.\n  max_distance: " +
      limit + "\ngates:\n";
  if (pair && !pair->sure)
    text += "  # Look at this: is " + in_yaml(pair->baselines) +
            " the folder of the wanted meshes? If not, swap the two.\n";
  if (writer.makes_baselines())
    text += "  # Baselines that do not exist are made by: meshgauge check gates.yaml --update-baselines\n";
  return FirstManifest{text + entries, writer.left_out};
}

std::string example_gate(const std::vector<std::string>& candidates, const std::string& baselines) {
  std::string candidate = candidates.empty() ? "parts/*.stl" : plain_in_glob(candidates.front());
  Names folders, suffixes;
  for (const std::string& file : candidates) {
    folders.insert(fs::path(file).parent_path().string());
    suffixes.insert(suffix_of(file));
  }
  if (folders.size() == 1 && suffixes.size() == 1 && candidates.size() > 1) {
    Names written;
    for (const std::string& file : candidates) written.insert(fs::path(file).extension().string());
    const bool alike =
        std::ranges::all_of(written, [&](const auto& one) { return one.size() == written.begin()->size(); });
    candidate = in_folder(plain_in_glob(*folders.begin()), "*" + (alike ? suffix_pattern(written) : *suffixes.begin()));
  }
  const bool single = !is_glob(candidate);
  const std::string stem = candidates.empty() || !single ? "{stem}" : fs::path(candidates.front()).stem().string();
  const std::string baseline = baselines + (single ? "/" + fs::path(candidate).filename().string() : "/{name}");
  return "{name: " + in_yaml(stem) + ", candidate: " + in_yaml(candidate) + ", baseline: " + in_yaml(baseline) +
         ", max_distance: 0.05 mm}";
}

std::string example_gate_of_folder(const std::string& folder, const std::string& baselines) {
  std::vector<std::string> candidates;
  if (auto found = meshes_below(folder); found && found->contains("")) {
    for (const std::string& name : (*found)[""]) candidates.push_back(folder + "/" + name);
  }
  if (candidates.empty()) candidates.push_back(folder + "/part.stl");
  if (candidates.size() == 1) candidates.push_back(candidates.front());  // a glob, also for one file
  return example_gate(candidates, baselines);
}

}  // namespace meshgauge::check
