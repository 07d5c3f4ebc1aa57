#include "check/manifest/manifest.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>
#include <system_error>

#include "api/base/descriptor.h"
#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"
#include "api/base/whole_file.h"
#include "api/compare/mesh_file.h"
#include "check/files.h"
#include "check/manifest/glob.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/naming.h"
#include "check/manifest/passed_over.h"
#include "check/manifest/spelling.h"
#include "check/manifest/yaml_tree.h"
#include "engine/result.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

// Whether two patterns have the same beginning, up to the first wildcard of either, and the same end.
bool meet_at_ends(std::string_view a, std::string_view b) {
  const std::size_t first = std::min(a.find_first_of("*?["), b.find_first_of("*?["));
  const auto behind = [](std::string_view text) { return text.size() - 1 - text.find_last_of("*?]"); };
  const std::size_t last = std::min(behind(a), behind(b));
  return a.substr(0, first) == b.substr(0, first) && a.substr(a.size() - last) == b.substr(b.size() - last);
}

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

// Whether "{dir}" is a part of a component of the template, as in "base/{dir}.off": its first folder is then part of
// another folder's name, and its last one of a file's.
bool has_folder_beside_text(std::string_view baseline) {
  const std::string kFolder = "\1";
  const std::vector<std::string> parts = components(filled(baseline, {"", "", kFolder}));
  return std::ranges::any_of(
      parts, [&](const std::string& part) { return part != kFolder && part.find(kFolder) != std::string::npos; });
}

// Placeholders side by side make "**" of two stars, which stands for folders where it is alone.
std::string with_single_stars(const std::string& pattern) {
  std::string out = pattern.starts_with('/') ? "/" : "";
  for (const std::string& part : components(pattern)) {
    if (!out.empty() && !out.ends_with('/')) out += '/';
    for (const char c : part) {
      if (c != '*' || part == "**" || !out.ends_with('*')) out += c;
    }
  }
  return out;
}

// Relative to the current folder if it lies below it, as a user would write it.
fs::path as_written(const fs::path& folder, const std::string& text) {
  const fs::path path = (folder / text).lexically_normal();
  if (path.is_relative() || fs::path(text).is_absolute()) return path;
  std::error_code failed;
  const fs::path here = fs::current_path(failed);
  return !failed && is_below(path, here) ? path.lexically_relative(here) : path;
}

// `only`: files of other gates need not exist; these gates are returned as well.
struct Lookup {
  Baselines baselines = Baselines::must_exist;
  const Selection& only;
  std::shared_ptr<const api::Confines> confines{};  // Gate::confines
  GlobConfines* globs = nullptr;                    // with them; null: without
};

// Expands the entries of a manifest to gates: looks up globs, fills in names, checks files.
class Expansion {
  struct Found {
    const Entry* entry;
    std::size_t first_gate;  // in `gates`
  };

 public:
  Expansion(const fs::path& manifest, const Lookup& lookup, Mistakes& mistakes)
      : manifest_(manifest.string()), folder_(manifest.parent_path()), lookup_(lookup), mistakes_(mistakes) {}

  std::vector<Gate> gates;
  std::vector<OpenBaselines> open;

  void add(const Entry& entry) {
    if (leads_out(entry)) return;
    std::map<std::string, std::string> taken;  // baseline -> its candidate, within this entry
    const std::vector<Match> found = candidates(entry);
    if (!found.empty()) found_.push_back({&entry, gates.size()});
    for (const Match& match : found) {
      if (gates.size() == kMaxGates) {
        mistakes_.add(entry.place, "more than " + std::to_string(kMaxGates) + " gates: split the manifest");
        return;
      }
      add(entry, match, taken);
    }
  }

  // Call when all gates are known: a file that one glob passes over may be that of another gate.
  void check_passed_over() {
    const Utf8Locale utf8;
    for (const Gate& gate : gates) taken_.emplace(spelling_key(gate.candidate.string()), gate.candidate);
    for (const Gate& gate : gates) taken_.emplace(spelling_key(gate.baseline.string()), gate.baseline);
    for (const Found& found : found_) {
      if (is_glob(found.entry->candidate.text)) check_passed_over(found);
    }
  }

  // Call when all gates are known, since the baseline of one entry may match the template of another. Skipped with
  // --only: a baseline does not tell whether its gate was selected.
  void check_unmatched() {
    if (lookup_.baselines == Baselines::may_be_missing || !lookup_.only.patterns().empty()) return;
    if (lookup_.baselines == Baselines::of_revision) return add_open();
    const Utf8Locale utf8;
    for (const Gate& gate : gates) {
      const fs::path place = place_of(gate.baseline);
      matched_.insert(place);
      expected_.emplace(spelling_key(place.string()), gate.baseline);
    }
    for (const Found& found : found_) {
      if (needs_candidates(*found.entry)) check_unmatched(*found.entry);
    }
  }

 private:
  // Whether its files may lie where none may be read, which is a mistake.
  bool leads_out(const Entry& entry) {
    bool is_out = false;
    for (const Written* path : {&entry.candidate, &entry.baseline}) {
      const std::vector<std::string> parts = components(path->text);
      const bool stays = !path->text.starts_with('/') && std::ranges::find(parts, std::string("..")) == parts.end();
      if (stays || !lookup_.confines) continue;
      mistakes_.add(path->place, "the path " + api::shown_text(path->text) +
                                     " may lead out of the folders that may be read: write it relative to the "
                                     "manifest's folder, without '..'");
      is_out = true;
    }
    return is_out;
  }

  std::vector<Match> candidates(const Entry& entry) {
    const Written& candidate = entry.candidate;
    if (candidate.text.empty()) return {};
    if (!is_glob(candidate.text)) return {{candidate.text, ""}};
    auto found = glob(root(), candidate.text, lookup_.globs);
    if (found && !found->empty()) return std::move(found).value();
    if (!lookup_.only.may_hold(filled(entry.name.text, {"*", "*", "*"}))) return {};
    mistakes_.add(candidate.place, subject_of(entry) + (found ? finds_nothing(candidate.text) : found.error().message));
    return {};
  }

  static std::string subject_of(const Entry& entry) {
    return "gate " + api::shown_text(entry.name.text) + ": the candidate " + api::shown_text(entry.candidate.text) +
           " ";
  }

  // Whether the file is that of a gate, by this path or by another in other case.
  bool is_taken(const std::string& path) const {
    const fs::path file = as_written(folder_, path);
    const auto [from, to] = taken_.equal_range(spelling_key(file.string()));
    const auto same = [&](const auto& one) { return one.second == file || is_same_file(one.second, file); };
    if (std::any_of(from, to, same)) return true;
    std::error_code none;
    return fs::is_symlink(file, none) &&
           std::any_of(taken_.begin(), taken_.end(), [&](const auto& one) { return is_same_file(one.second, file); });
  }

  void check_passed_over(const Found& found) {
    const Entry& entry = *found.entry;
    PassedOverFiles over = passed_over(root(), entry.candidate.text, lookup_.globs);
    std::erase_if(over.files, [&](const PassedOver& file) {
      const std::string name = fs::path(file.path).filename().string();
      NameParts parts = name_parts(name, "*");
      return is_taken(file.path) || !lookup_.only.may_hold(filled(entry.name.text, parts));
    });
    for (const std::string& words : passed_over_in_words(entry.candidate.text, over.files))
      mistakes_.add(entry.candidate.place, subject_of(entry) + words);
    const std::string hidden = hidden_in_words(entry.candidate.text, over);
    if (!hidden.empty() && found.first_gate < gates.size()) gates[found.first_gate].notes.push_back(hidden);
  }

  fs::path root() const { return folder_.empty() ? "." : folder_; }

  // Whether each file that its template of baselines matches needs a candidate.
  static bool needs_candidates(const Entry& entry) {
    return is_glob(entry.candidate.text) && has_placeholder(entry.baseline.text) && !entry.unmatched_ignored;
  }

  void add_open() {
    for (const Found& found : found_) {
      const Entry& entry = *found.entry;
      if (!needs_candidates(entry)) continue;
      Gate gate = entry.gate;
      gate.manifest = manifest_;
      gate.line = entry.baseline.place.line;
      for (std::string& pattern : baseline_globs(entry.candidate.text, entry.baseline.text))
        open.push_back({gate, root(), std::move(pattern), lack_of(entry)});
    }
  }

  static std::string lack_of(const Entry& entry) {
    return "has no candidate: " + api::shown_text(entry.candidate.text) + " finds none";
  }

  void check_unmatched(const Entry& entry) {
    for (const std::string& pattern : baseline_globs(entry.candidate.text, entry.baseline.text))
      check_matches(entry, pattern);
  }

  void check_matches(const Entry& entry, const std::string& pattern) {
    const auto found = glob(root(), pattern, lookup_.globs);
    if (!found) {
      mistakes_.add(entry.baseline.place, "gate " + api::shown_text(entry.name.text) + ": the baseline " +
                                              api::shown_text(entry.baseline.text) + " " + found.error().message);
      return;
    }
    for (const Match& match : *found) check_unmatched(entry, match.path);
    for (const PassedOver& file : passed_over(root(), pattern, lookup_.globs).files) {
      if ((file.why & of_leading_dot) == 0 && !is_taken(file.path)) check_unmatched(entry, file.path);
    }
  }

  void check_unmatched(const Entry& entry, const std::string& path) {
    const fs::path baseline = as_written(folder_, path);
    const fs::path place = place_of(baseline);
    if (!matched_.insert(place).second) return;
    const auto near = expected_.find(spelling_key(place.string()));
    const std::string like = near == expected_.end() ? ""
                                                     : ", which differs only by case or blanks from " +
                                                           shown_path(near->second) + ", the baseline of a gate,";
    mistakes_.add(entry.baseline.place, "the baseline " + shown_path(baseline) + like + " " + lack_of(entry) +
                                            "; when there is to be none, remove the baseline, or write "
                                            "'unmatched_baselines: ignore'");
  }

  // Resolves links of the folder, so that each baseline has one place.
  fs::path place_of(const fs::path& baseline) {
    const fs::path folder = baseline.has_parent_path() ? baseline.parent_path() : fs::path(".");
    const auto [known, is_new] = folders_.emplace(folder, folder);
    if (is_new) {
      std::error_code failed;
      fs::path real = fs::weakly_canonical(folder, failed);
      if (!failed) known->second = std::move(real);
    }
    return known->second / baseline.filename();
  }

  // Whether there is a file of exactly this name.
  bool is_file(const std::string& path) const {
    std::error_code none;
    if (!lookup_.globs) return fs::exists(folder_ / path, none);
    std::string name;
    for (const std::string& part : components(path)) name = joined(name, part);
    return api::WholeFile::size_below(lookup_.globs->folder, name).ok();
  }

  std::string finds_nothing(const std::string& pattern) const {
    if (is_file(pattern)) {
      return "finds no file, though there is one of exactly this name: write '[[]' for a '[' in it";
    }
    const PassedOverFiles over = passed_over(root(), pattern, lookup_.globs);
    std::string near;
    for (const std::string& words : passed_over_in_words(pattern, over.files)) near += "; it " + words;
    if (const std::string hidden = hidden_in_words(pattern, over); !hidden.empty()) near += "; " + hidden;
    if (!near.empty()) return "finds no file" + near;
    const std::string from = folder_.empty() ? "the manifest's folder" : shown_path(folder_);
    const bool backslash = pattern.find('\\') != std::string::npos;
    return "finds no file; paths are relative to " + from + (backslash ? ", and folders are separated by '/'" : "");
  }

  void add(const Entry& entry, const Match& match, std::map<std::string, std::string>& taken) {
    const NameParts parts = name_parts(fs::path(match.path).filename().string(), match.dir);
    Gate gate = entry.gate;
    gate.manifest = manifest_;
    gate.confines = lookup_.confines;
    gate.name = filled(entry.name.text, parts);
    gate.candidate = as_written(folder_, match.path);
    check_name(entry, gate.name);
    const bool asked_for = lookup_.only.holds(gate.name);
    if (asked_for) check_candidate(entry, gate);
    if (!entry.baseline.text.empty()) {
      const std::string baseline = filled(entry.baseline.text, parts);
      gate.baseline = as_written(folder_, baseline);
      if (asked_for) check_baseline(entry, gate);
      const auto [first, is_new] = taken.emplace(gate.baseline.string(), match.path);
      if (!is_new && has_placeholder(entry.baseline.text)) twice(entry, gate, first->second, match.path);
    }
    gates.push_back(std::move(gate));
  }

  void check_name(const Entry& entry, const std::string& name) {
    if (name.empty()) return;  // already reported
    if (!is_utf8(name) || find_control(name) != std::string::npos) {
      mistakes_.add(entry.name.place, "name " + api::shown_text(name) + " is made of a file name that " +
                                          (is_utf8(name) ? "has a control character" : "is not UTF-8") +
                                          ": rename the file");
      return;
    }
    const auto [first, is_new] = lines_.emplace(name, entry.place.line);
    if (is_new) return;
    std::string message = "the name " + api::shown_text(name) + " is taken ";
    if (first->second == entry.place.line) {
      message += has_placeholder(entry.name.text) ? "twice in this gate: write {dir} in it as well"
                                                  : "by another file of this gate: write {stem} in it";
    } else {
      message += "by the gate in line " + std::to_string(first->second);
    }
    mistakes_.add(entry.name.place, message);
  }

  // Whether the file may be read, if that is confined; what is wrong is a defect of the gate.
  bool check_confined(Gate& gate, Place place, const fs::path& file, const std::string& what) const {
    if (!gate.confines) return true;
    std::error_code failed;
    const auto found = gate.confines->roots.find(fs::absolute(file, failed).string());
    const auto size =
        found ? api::WholeFile::size_below(found->folder, found->name) : Result<std::uint64_t>(found.error());
    if (!size) add_defect(gate, place, what + " " + size.error().message);
    return size.ok();
  }

  void check_candidate(const Entry& entry, Gate& gate) {
    if (!check_confined(gate, entry.candidate.place, gate.candidate, "the candidate") || gate.confines) return;
    if (const auto wrong = file_defect(gate.candidate))
      add_defect(
          gate, entry.candidate.place,
          "the candidate " + shown_path(gate.candidate) + " " + *wrong + hint(gate.candidate, entry.candidate.text));
  }

  void check_baseline(const Entry& entry, Gate& gate) {
    if (lookup_.baselines == Baselines::of_revision) return;
    if (!check_confined(gate, entry.baseline.place, gate.baseline, "the baseline")) return;
    const std::string subject = "the baseline " + shown_path(gate.baseline) + " ";
    if (is_same_file(gate.candidate, gate.baseline)) {
      mistakes_.add(entry.baseline.place, "gate " + api::shown_text(gate.name) + ": " + subject +
                                              "is the candidate itself: the gate would always pass");
      return;
    }
    if (gate.confines) return;  // it was opened, where it is confined
    const auto wrong = file_defect(gate.baseline);
    std::error_code none;
    const bool missing = !fs::exists(fs::symlink_status(gate.baseline, none));
    if (!wrong || (missing && lookup_.baselines == Baselines::may_be_missing)) return;
    std::string advice = missing ? hint(gate.baseline, entry.baseline.text) : "";
    if (missing && advice.find("there is ") == std::string::npos)
      advice += "; when the candidate is right, make it one by --update-baselines";
    add_defect(gate, entry.baseline.place, subject + *wrong + advice);
  }

  static void add_defect(Gate& gate, Place place, std::string what) {
    gate.defects.push_back({place.line, place.column, std::move(what)});
  }

  void twice(const Entry& entry, const Gate& gate, const std::string& first, const std::string& second) {
    mistakes_.add(entry.baseline.place, "the baseline " + shown_path(gate.baseline) + " is that of both " +
                                            api::shown_text(first) + " and " + api::shown_text(second) +
                                            ": write {dir} in it as well");
  }

  // Names the manifest's folder, in case the current one was meant, or another spelling of the path that exists.
  std::string hint(const fs::path& file, const std::string& text) {
    std::error_code none;
    if (fs::exists(fs::symlink_status(file, none))) return "";  // a link to nothing
    const bool here = !folder_.empty() && fs::path(text).is_relative() && fs::exists(text, none);
    return here ? "; it does in the current folder, but paths are relative to the manifest's"
                : spelling_hint(file, spellings_);
  }

  std::string manifest_;
  fs::path folder_;
  Lookup lookup_;
  Mistakes& mistakes_;
  std::map<std::string, int> lines_;            // gate name -> line
  std::vector<Found> found_;                    // entries whose candidates exist
  std::set<fs::path> matched_;                  // places of the gates' baselines
  std::map<fs::path, fs::path> folders_;        // folders of baselines, without links
  std::map<std::string, fs::path> expected_;    // as spelling_key() -> baseline of a gate
  std::multimap<std::string, fs::path> taken_;  // as spelling_key() -> file of a gate
  Spellings spellings_;
};

// Returns the gates. A missing or unusable file is a defect of its gate. Adds mistakes at the entry's candidate,
// baseline or name: a glob without matches, or one that passes over files; a candidate that is its own baseline; a
// baseline with a placeholder that is the same for two candidates; two gates of one name; a baseline that matches a
// glob's template and has no candidate. The last is skipped for --update-baselines and with `only`; for --against the
// templates are returned instead.
Gates expand(const std::vector<Entry>& entries, const fs::path& manifest, const Lookup& lookup, Mistakes& mistakes) {
  Expansion expansion(manifest, lookup, mistakes);
  for (const Entry& entry : entries) expansion.add(entry);
  expansion.check_passed_over();
  expansion.check_unmatched();
  return {std::move(expansion.gates), {}, std::move(expansion.open)};
}

Result<std::string> read_confined(const api::Roots::Place& place) {
  const auto file = api::WholeFile::open_below(place.folder, place.name, kMaxYamlBytes);
  if (!file) return file.error();
  return std::string(api::as_text(file->bytes()));
}

Result<api::BaseFolder> held_folder(const api::Roots::Place& manifest) {
  const std::size_t end = manifest.name.rfind('/');
  const std::string name = end == std::string::npos ? "" : manifest.name.substr(0, end);
  auto held = api::open_folder_below(manifest.folder, name);
  if (!held) return std::move(held).error();
  const std::string path = manifest.folder.path + (name.empty() ? "" : "/" + name);
  return api::BaseFolder{path, std::make_shared<const Descriptor>(std::move(*held))};
}

Result<std::string> read_file(const std::filesystem::path& file) {
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) return refused("is a folder: name the manifest in it");
  return api::read_text_file(file.string(), kMaxYamlBytes);
}

// Nothing is measured, so all is said at once.
void add_defects(const std::vector<Gate>& gates, Mistakes& mistakes) {
  for (const Gate& gate : gates) {
    for (const Mistake& defect : gate.defects)
      mistakes.add({defect.line, defect.column}, "gate " + api::shown_text(gate.name) + ": " + defect.message);
  }
}

// `text`: of the manifest.
Gates gates_in(const Result<std::string>& text, const fs::path& manifest, const Lookup& lookup) {
  Mistakes mistakes;
  Gates result;
  if (text) {
    result = expand(read_manifest(*text, mistakes), manifest, lookup, mistakes);
    if (!mistakes.empty()) add_defects(result.gates, mistakes);
  } else {
    mistakes.add({}, text.error().message);
  }
  result.mistakes = std::move(mistakes).sorted();
  return result;
}

}  // namespace

bool Selection::holds(std::string_view name) const {
  const auto matching = [&](const std::string& pattern) { return matches(pattern, std::string(name)); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), matching);
}

bool Selection::may_hold(std::string_view name_pattern) const {
  if (!is_glob(name_pattern)) return holds(name_pattern);
  const auto meeting = [&](const std::string& pattern) { return meet_at_ends(pattern, name_pattern); };
  return patterns_.empty() || std::any_of(patterns_.begin(), patterns_.end(), meeting);
}

std::vector<std::string> baseline_globs(std::string_view candidate, std::string_view baseline) {
  const std::string text = literal(baseline);
  NameParts patterns = patterns_of(candidate);
  const std::vector<std::string> folders = components(patterns.dir);
  const bool any_folders = std::ranges::find(folders, std::string("**")) != folders.end();
  if (!any_folders || !has_folder_beside_text(text)) return {with_single_stars(filled(text, patterns))};
  std::vector<std::string> globs;
  for (const char* value : {"*", "*/**/*"}) {
    patterns.dir = value;
    globs.push_back(with_single_stars(filled(text, patterns)));
  }
  return globs;
}

std::vector<Mistake> defects_of(const Gates& read) {
  if (!read.mistakes.empty()) return read.mistakes;
  Mistakes defects;
  add_defects(read.gates, defects);
  return std::move(defects).sorted();
}

Gates gates_of(const std::filesystem::path& manifest, Baselines baselines, const Selection& only) {
  return gates_in(read_file(manifest), manifest, {baselines, only, nullptr, nullptr});
}

Gates gates_within(const std::shared_ptr<const api::Confines>& confines, const std::string& manifest,
                   const Selection& only, const Interrupted& interrupted) {
  const auto place = confines->roots.find(manifest);
  const auto text = place ? read_confined(*place) : Result<std::string>(place.error());
  const auto folder = text ? held_folder(*place) : Result<api::BaseFolder>(text.error());
  GlobConfines globs{folder ? *folder : api::BaseFolder{}, interrupted};
  Gates read = gates_in(folder ? text : Result<std::string>(folder.error()), place ? place->path() : manifest,
                        {Baselines::must_exist, only, confines, &globs});
  if (interrupted()) read.mistakes.push_back({0, 0, "the time was over before all files of the manifest were found"});
  return read;
}

}  // namespace meshgauge::check
