// Parts of patterns of files, for what looks them up.
#pragma once

#include <locale.h>

#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::check {

// Makes fnmatch() in this thread treat characters as UTF-8 while it lives, whatever the process's locale.
class Utf8Locale {
 public:
  Utf8Locale();
  ~Utf8Locale();
  Utf8Locale(const Utf8Locale&) = delete;
  Utf8Locale& operator=(const Utf8Locale&) = delete;

 private:
  locale_t locale_;
  locale_t before_{};
};

// Returns what stands between the slashes. Several '**' in a row are one.
std::vector<std::string> components(std::string_view pattern);

// Whether every bracket of the component is closed.
bool has_closed_brackets(std::string_view component);

// Whether a wildcard may match the name; a leading dot only a dot. Precondition: a Utf8Locale lives.
bool matches_file(const std::string& component, const std::string& name);

std::string joined(const std::string& folder, const std::string& name);

}  // namespace meshgauge::check
