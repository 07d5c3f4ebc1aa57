#include "check/manifest/naming.h"

#include <functional>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/suggestion.h"
#include "api/base/text.h"

namespace meshgauge::check {
namespace {

constexpr std::string_view kPlaceholders[] = {"stem", "name", "dir"};

// The suffix of a compressed file is the mesh's.
bool is_gzip(const std::filesystem::path& file) { return api::same_word(file.extension().native(), ".gz"); }

// Calls `text` for each piece outside of braces and `placeholder` for each name inside, in order. Returning false
// ends the visit.
struct Visitor {
  std::function<bool(std::string_view)> text;
  std::function<bool(std::string_view)> placeholder;
};

// False: a brace has no partner.
bool visit(std::string_view rest, const Visitor& visitor) {
  while (!rest.empty()) {
    const std::size_t open = rest.find('{');
    const std::string_view before = rest.substr(0, open);
    if (before.find('}') != std::string_view::npos) return false;
    if (!visitor.text(before)) return true;
    if (open == std::string_view::npos) return true;
    const std::size_t close = rest.find_first_of("{}", open + 1);
    if (close == std::string_view::npos || rest[close] == '{') return false;
    if (!visitor.placeholder(rest.substr(open + 1, close - open - 1))) return true;
    rest.remove_prefix(close + 1);
  }
  return true;
}

}  // namespace

NameParts name_parts(std::string_view file_name, std::string dir) {
  std::filesystem::path file(file_name);
  if (is_gzip(file)) file = file.stem();
  return {file.stem().string(), std::string(file_name), std::move(dir)};
}

std::string suffix_of(const std::filesystem::path& file) {
  std::string suffix = file.extension().string();
  if (is_gzip(file)) suffix = file.stem().extension().string() + suffix;
  return api::lower_case(std::move(suffix));
}

Result<Done> check_template(std::string_view text) {
  std::string unknown;
  const auto anything = [](std::string_view) { return true; };
  const auto known = [&](std::string_view word) {
    for (const std::string_view one : kPlaceholders) {
      if (word == one) return true;
    }
    unknown = "has an unknown placeholder " + api::shown_text("{" + std::string(word) + "}") +
              api::suggestion(word, kPlaceholders);
    return false;
  };
  if (!visit(text, {anything, known})) {
    return refused("has a brace without its partner; braces hold {stem}, {name} or {dir} and nothing else");
  }
  if (!unknown.empty()) return refused(unknown);
  return Done{};
}

bool has_placeholder(std::string_view text) { return text.find('{') != std::string_view::npos; }

std::string filled(std::string_view text, const NameParts& parts) {
  std::string out;
  bool no_folder = false;  // a following slash would make the path absolute
  const auto copy = [&](std::string_view plain) {
    if (no_folder && !plain.starts_with('/')) out += '.';
    out += no_folder && plain.starts_with('/') ? plain.substr(1) : plain;
    no_folder = false;
    return true;
  };
  const auto fill = [&](std::string_view word) {
    if (word == "stem") out += parts.stem;
    if (word == "name") out += parts.name;
    if (word == "dir") out += parts.dir;
    no_folder = word == "dir" && parts.dir.empty();
    return true;
  };
  visit(text, {copy, fill});
  if (no_folder) out += '.';
  return out;
}

}  // namespace meshgauge::check
