#include "check/manifest/pattern.h"

#include <fnmatch.h>

#include <cstddef>

namespace meshgauge::check {
namespace {

// A ']' directly after the bracket, or after its '!', is an ordinary character.
bool is_closed(std::string_view bracket) {
  std::size_t from = 1;
  if (from < bracket.size() && (bracket[from] == '!' || bracket[from] == '^')) ++from;
  return bracket.find(']', from + 1) != std::string_view::npos;
}

}  // namespace

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
