#include "check/manifest/passed_over.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "api/base/json_filter.h"
#include "api/formats/detect.h"
#include "check/files.h"
#include "check/manifest/glob.h"
#include "check/manifest/spelling.h"

namespace meshgauge::check {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostNamed = 32, kMostBytes = 4000;  // in one message

// Returns the pattern with '/' for each '\', unless that cuts a bracket.
std::string with_slashes(std::string_view pattern) {
  std::string out(pattern);
  std::ranges::replace(out, '\\', '/');
  return std::ranges::all_of(components(out), has_closed_brackets) && check_glob(out) ? out : std::string(pattern);
}

class Look {
 public:
  Look(fs::path folder, const std::string& pattern, GlobConfines* confines)
      : folder_(std::move(folder)),
        parts_(components(pattern)),
        confines_(confines),
        entries_left_(confines ? confines->entries_left : own_entries_left_) {
    if (pattern.starts_with('/')) {
      while (fixed_ + 1 < parts_.size() && !is_glob(parts_[fixed_])) ++fixed_;
    }
    if (parts_.back() == "**") parts_.emplace_back("*");
  }

  PassedOverFiles found;

  void into(const std::string& written, std::size_t i, unsigned why) {
    const std::string& part = parts_[i];
    if (part == ".." || part == ".") return i + 1 < parts_.size() ? into(joined(written, part), i + 1, why) : void();
    if (part == "**") return below(written, i, why);
    std::error_code none;
    if (i < fixed_ && fs::is_directory(folder_ / joined(written, part), none))
      return into(joined(written, part), i + 1, why);
    each(written, [&](const fs::directory_entry& entry, const std::string& name) {
      const auto more = differences(part, name);
      if (i + 1 == parts_.size() && more) add(entry, joined(written, name), why | *more);
      if (i + 1 < parts_.size() && more && is_folder(entry)) into(joined(written, name), i + 1, why | *more);
      if (i + 1 < parts_.size()) add_archived(entry, joined(written, name), name, i, why);
    });
  }

 private:
  bool is_folder(const fs::directory_entry& entry) const {
    std::error_code none;
    return entry.is_directory(none) && (!confines_ || !entry.is_symlink(none));
  }

  template <class Visit>
  void each(const std::string& written, Visit visit) {
    const auto folder = listed_folder(folder_, written, confines_);
    if (!folder) return;
    std::error_code failed;
    for (fs::directory_iterator it(folder->path, failed), end; !failed && found.all && it != end;
         it.increment(failed)) {
      const bool is_over = confines_ && confines_->interrupted();
      if (is_over || entries_left_ == 0 || found.files.size() >= kMaxGlobMatches) found.all = false;
      count(1);
      visit(*it, it->path().filename().string());
    }
  }

  void count(std::size_t entries) { entries_left_ -= std::min(entries_left_, entries); }

  void below(const std::string& written, std::size_t i, unsigned why) {
    into(written, i + 1, why);
    each(written, [&](const fs::directory_entry& entry, const std::string& name) {
      std::error_code none;
      add_archived(entry, joined(written, name), name, i, why);
      if (entry.is_symlink(none) || !entry.is_directory(none)) return;
      below(joined(written, name), i, why | (name.starts_with('.') ? unsigned{of_leading_dot} : 0U));
    });
  }

  void add(const fs::directory_entry& entry, const std::string& path, unsigned why) {
    std::error_code failed;
    if (why == 0 || (!entry.is_regular_file(failed) && !failed)) return;
    if ((why & of_leading_dot) != 0 && !api::format_by_name(path)) return;
    found.files.push_back({path, why});
  }

  // A program that unpacks an archive of Windows may make a file 'parts\x.stl' in place of a folder.
  void add_archived(const fs::directory_entry& entry, const std::string& path, std::string name, std::size_t i,
                    unsigned why) {
    if (name.find('\\') == std::string::npos) return;
    std::ranges::replace(name, '\\', '/');
    const std::vector<std::string> names = components(name);
    count(names.size() * (parts_.size() - i));
    if (const auto more = differences(std::span(parts_).subspan(i), names))
      add(entry, path, why | *more | of_backslashes);
  }

  fs::path folder_;
  std::vector<std::string> parts_;
  GlobConfines* const confines_;
  std::size_t fixed_ = 0;  // components of an absolute pattern whose other spellings are of no interest
  std::size_t own_entries_left_ = kMaxGlobEntries;
  std::size_t& entries_left_;
};

std::string list_of(const std::vector<std::string>& paths) {
  std::string text;
  std::size_t i = 0;
  for (; i < std::min(paths.size(), kMostNamed) && text.size() < kMostBytes; ++i) {
    const bool last = i > 0 && i + 1 == paths.size();
    text += (i == 0 ? "" : last ? " and " : ", ") + shown_path(paths[i]);
  }
  return i < paths.size() ? text + " and " + std::to_string(paths.size() - i) + " more" : text;
}

std::string them(const std::vector<std::string>& paths) { return paths.size() == 1 ? "it" : "them"; }

std::string of_case(std::string_view pattern, const std::vector<std::string>& paths) {
  const std::string both = with_both_cases(pattern, paths);
  const std::string remedy =
      both.empty() ? "rename " + them(paths) : "write " + shown_path(both) + " to take both, or rename " + them(paths);
  return "passes over " + list_of(paths) + ", which it misses only by upper and lower case: " + remedy;
}

std::string of_blanks(const std::vector<std::string>& paths) {
  return "passes over " + list_of(paths) + ", which it misses only by blanks at the ends of names: rename " +
         them(paths);
}

std::string of_backslash(std::string_view pattern, const std::vector<std::string>& paths) {
  const bool own = pattern.find('\\') != std::string_view::npos;
  return "passes over " + list_of(paths) + ": folders are separated by '/', not by '\\'; " +
         (own ? "write " + shown_path(with_slashes(pattern)) : "move " + them(paths) + " into the folder");
}

}  // namespace

PassedOverFiles passed_over(const fs::path& folder, std::string_view pattern, GlobConfines* confines) {
  const Utf8Locale utf8;
  const std::string meant = with_slashes(pattern);
  Look look(folder, meant, confines);
  look.into(pattern.starts_with('/') ? "/" : "", 0, meant == pattern ? 0U : unsigned{of_backslashes});
  std::vector<PassedOver>& files = look.found.files;
  std::ranges::sort(files,
                    [](const auto& x, const auto& y) { return std::tie(x.path, x.why) < std::tie(y.path, y.why); });
  const auto is_same = [](const PassedOver& x, const PassedOver& y) { return x.path == y.path; };
  files.erase(std::unique(files.begin(), files.end(), is_same), files.end());
  return std::move(look.found);
}

std::vector<std::string> passed_over_in_words(std::string_view pattern, const std::vector<PassedOver>& files) {
  const Utf8Locale utf8;
  std::vector<std::string> by_case, by_blanks, by_backslash;
  for (const PassedOver& file : files) {
    if ((file.why & of_leading_dot) != 0) continue;
    ((file.why & of_backslashes) != 0      ? by_backslash
     : (file.why & of_blanks_at_ends) != 0 ? by_blanks
                                           : by_case)
        .push_back(file.path);
  }
  std::vector<std::string> sentences;
  if (!by_case.empty()) sentences.push_back(of_case(pattern, by_case));
  if (!by_blanks.empty()) sentences.push_back(of_blanks(by_blanks));
  if (!by_backslash.empty()) sentences.push_back(of_backslash(pattern, by_backslash));
  return sentences;
}

std::string hidden_in_words(std::string_view pattern, const PassedOverFiles& found) {
  std::vector<std::string> hidden;
  for (const PassedOver& file : found.files) {
    if ((file.why & of_leading_dot) != 0) hidden.push_back(file.path);
  }
  std::string text;
  if (!hidden.empty())
    text = api::shown_text(pattern) + " passes over " + list_of(hidden) + ": a wildcard matches no leading dot, so " +
           (hidden.size() == 1 ? "it is" : "they are") + " not measured";
  if (!found.all)
    text += (text.empty() ? api::shown_text(pattern) + " passes over files: there are" : "; there are") +
            std::string(" too many beside it to name all that it passes over");
  return text;
}

}  // namespace meshgauge::check
