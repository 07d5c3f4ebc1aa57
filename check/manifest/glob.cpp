#include "check/manifest/glob.h"

#include <fnmatch.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "check/files.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

// A ']' directly after the bracket, or after its '!', is an ordinary character.
bool is_closed(std::string_view bracket) {
  std::size_t from = 1;
  if (from < bracket.size() && (bracket[from] == '!' || bracket[from] == '^')) ++from;
  return bracket.find(']', from + 1) != std::string_view::npos;
}

bool is_missing(const std::error_code& failed) {
  return failed == std::errc::no_such_file_or_directory || failed == std::errc::not_a_directory;
}

fs::path held_path(const Descriptor& held) { return "/proc/self/fd/" + std::to_string(held.get()); }

class Walk {
 public:
  Walk(fs::path folder, std::string_view pattern, GlobConfines* confines)
      : folder_(std::move(folder)),
        parts_(components(pattern)),
        confines_(confines),
        entries_left_(confines ? confines->entries_left : own_entries_left_) {
    while (fixed_ + 1 < parts_.size() && !is_glob(parts_[fixed_])) ++fixed_;
    if (parts_.back() == "**") parts_.emplace_back("*");
  }

  // `written`: the path so far, in the pattern's form; `dir`: its part from the first wildcard on.
  void into(const std::string& written, const std::string& dir, std::size_t i) {
    if (i + 1 == parts_.size()) return files(written, dir, parts_[i]);
    if (parts_[i] == "**") return below(written, dir, i);
    if (is_glob(parts_[i])) return folders(written, dir, i);
    const std::string next = joined(written, parts_[i]);
    if (is_folder(next)) into(next, i < fixed_ ? dir : joined(dir, parts_[i]), i + 1);
  }

  std::vector<Match> found;
  std::optional<Error> error;

 private:
  // A path that does not exist is skipped. Any other failure is an error, since candidates may be there.
  void stop_if(const std::error_code& failed, const fs::path& path) {
    if (!failed || is_missing(failed) || error) return;
    error = refused("cannot be looked up: " + shown_path(path) + ": " + failed.message());
  }

  bool is_folder(const std::string& written) {
    std::error_code failed, none;
    const fs::path place = (confines_ ? held_path(*confines_->folder.held) : folder_) / written;
    const bool is = fs::is_directory(place, failed);
    stop_if(failed, folder_ / written);
    return is && !is_refused(fs::is_symlink(place, none), written);
  }

  bool is_folder(const fs::directory_entry& entry, const std::string& written) {
    std::error_code failed, none;
    const bool is = entry.is_directory(failed);
    stop_if(failed, folder_ / written);
    return is && !is_refused(entry.is_symlink(none), written);
  }

  bool is_refused(bool is_link, const std::string& written) {
    if (!confines_ || !is_link) return false;
    if (!error) error = refused("finds the symbolic link " + shown_path(folder_ / written) + ", which is not followed");
    return true;
  }

  // Whether one more entry may be looked at; else that is the error.
  bool count_entry() {
    if (confines_ && confines_->interrupted()) {
      error = refused("cannot be looked up: the time for it is over");
    } else if (entries_left_ == 0) {
      error = refused("looks at more than " + std::to_string(kMaxGlobEntries) + " files; name the folder more exactly");
    } else {
      --entries_left_;
    }
    return !error;
  }

  // Calls visit(entry, name) for each entry of a folder.
  template <class Visit>
  void each(const std::string& written, Visit visit) {
    const auto folder = listed_folder(folder_, written, confines_);
    if (!folder) {
      error = refused("cannot be looked up: " + folder.error().message);
      return;
    }
    std::error_code failed;
    for (fs::directory_iterator it(folder->path, failed), end; !failed && !error && it != end; it.increment(failed)) {
      if (!count_entry()) return;
      visit(*it, it->path().filename().string());
    }
    if (failed && (confines_ || !is_missing(failed)))
      error = refused("finds the folder " + shown_path(folder_ / written) + " unreadable: " + failed.message());
  }

  void files(const std::string& written, const std::string& dir, const std::string& part) {
    each(written, [&](const fs::directory_entry& entry, const std::string& name) {
      if (!matches_file(part, name)) return;
      std::error_code failed;
      // An entry that cannot be examined, such as a dangling link, counts as a match: leaving it out would let its
      // gate pass.
      if (!entry.is_regular_file(failed) && !failed) return;
      found.push_back({joined(written, name), dir});
      if (found.size() > kMaxGlobMatches)
        error = refused("finds more than " + std::to_string(kMaxGlobMatches) + " files");
    });
  }

  void folders(const std::string& written, const std::string& dir, std::size_t i) {
    each(written, [&](const fs::directory_entry& entry, const std::string& name) {
      const std::string path = joined(written, name);
      if (matches_file(parts_[i], name) && is_folder(entry, path)) into(path, joined(dir, name), i + 1);
    });
  }

  void below(const std::string& written, const std::string& dir, std::size_t i) {
    into(written, dir, i + 1);
    each(written, [&](const fs::directory_entry& entry, const std::string& name) {
      std::error_code none;
      const std::string path = joined(written, name);
      if (name.starts_with('.') || entry.is_symlink(none) || !is_folder(entry, path)) return;
      below(path, joined(dir, name), i);
    });
  }

  fs::path folder_;
  std::vector<std::string> parts_;
  GlobConfines* const confines_;
  std::size_t fixed_ = 0;  // components before the first wildcard
  std::size_t own_entries_left_ = kMaxGlobEntries;
  std::size_t& entries_left_;
};

}  // namespace

bool is_glob(std::string_view pattern) { return pattern.find_first_of("*?[") != std::string_view::npos; }

bool matches(const std::string& pattern, const std::string& text) {
  const Utf8Locale utf8;
  return fnmatch(pattern.c_str(), text.c_str(), FNM_NOESCAPE) == 0;
}

Result<Done> check_glob(std::string_view pattern) {
  if (pattern.ends_with('/')) return refused("must name files, and ends in '/'");
  for (const std::string& part : components(pattern)) {
    if (part != "**" && part.find("**") != std::string::npos) {
      return refused("has '**' beside other characters in " + api::shown_text(part) +
                     ": between two slashes it stands alone, for any folders");
    }
    if (!has_closed_brackets(part)) {
      return refused("has a '[' that is not closed; for the character itself write '[[]'");
    }
  }
  return Done{};
}

Result<std::vector<Match>> glob(const fs::path& folder, std::string_view pattern, GlobConfines* confines) {
  const Utf8Locale utf8;
  Walk walk(folder, pattern, confines);
  walk.into(pattern.starts_with('/') ? "/" : "", "", 0);
  if (walk.error) return *walk.error;
  std::ranges::sort(walk.found, {}, &Match::path);
  const auto is_same = [](const Match& x, const Match& y) { return x.path == y.path; };
  walk.found.erase(std::unique(walk.found.begin(), walk.found.end(), is_same), walk.found.end());
  return std::move(walk.found);
}

Result<ListedFolder> listed_folder(const fs::path& folder, const std::string& written, const GlobConfines* confines) {
  if (!confines) return ListedFolder{written.empty() ? folder : folder / written};
  auto held = api::open_folder_below(confines->folder, written);
  if (!held) return std::move(held).error();
  const fs::path path = held_path(*held);
  return ListedFolder{path, std::move(*held)};
}

Utf8Locale::Utf8Locale() : locale_(newlocale(LC_CTYPE_MASK, "C.UTF-8", nullptr)) {
  if (locale_) before_ = uselocale(locale_);
}

Utf8Locale::~Utf8Locale() {
  if (!locale_) return;
  uselocale(before_);
  freelocale(locale_);
}

std::vector<std::string> components(std::string_view pattern) {
  std::vector<std::string> parts;
  while (!pattern.empty()) {
    const std::size_t slash = pattern.find('/');
    const std::string_view part = pattern.substr(0, slash);
    pattern.remove_prefix(slash == std::string_view::npos ? pattern.size() : slash + 1);
    const bool again = part == "**" && !parts.empty() && parts.back() == "**";
    if (!part.empty() && !again) parts.emplace_back(part);
  }
  return parts;
}

bool has_closed_brackets(std::string_view component) {
  for (std::size_t open = component.find('['); open != std::string_view::npos;
       open = component.find('[', component.find(']', open + 2))) {
    if (!is_closed(component.substr(open))) return false;
  }
  return true;
}

bool matches_file(const std::string& component, const std::string& name) {
  return fnmatch(component.c_str(), name.c_str(), FNM_PERIOD | FNM_NOESCAPE) == 0;
}

std::string joined(const std::string& folder, const std::string& name) {
  if (folder.empty() || folder.ends_with('/')) return folder + name;
  return folder + '/' + name;
}

}  // namespace meshgauge::check
