#include "server/http/name_for_file.h"

#include <algorithm>

#include "api/formats/detect.h"
#include "api/formats/file/source.h"
#include "server/http/multipart.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kMostTextBytes = 1024;
constexpr std::size_t kMostShown = 100;
constexpr std::size_t kMostExtension = 8;

// "part.step", but no number such as "1.5".
bool has_extension(std::string_view word) {
  const std::size_t dot = word.rfind('.');
  if (dot == std::string_view::npos || dot == 0) return false;
  const std::string_view extension = word.substr(dot + 1);
  return !extension.empty() && extension.size() <= kMostExtension && is_letter(extension.front()) &&
         std::ranges::all_of(extension, [](char c) { return is_letter(c) || is_digit(c); });
}

bool is_name(std::string_view line) {
  for (const std::string_view beginning : {"@", "/", "./", "../", "~/"}) {
    if (line.starts_with(beginning)) return true;
  }
  if (line.starts_with("solid ")) return false;  // an ASCII STL of one line
  return api::format_by_name(line) || (line.find_first_of(" \t") == std::string_view::npos && has_extension(line));
}

}  // namespace

std::optional<api::Problem> refuse_name_for_file(const std::string& field, std::string_view content) {
  if (content.size() > kMostTextBytes) return std::nullopt;
  if (content.ends_with('\n')) content.remove_suffix(1);
  if (content.ends_with('\r')) content.remove_suffix(1);
  const std::string_view line = trimmed(content);
  if (line.empty() || line.size() == 1 || !is_field_text(line) || !is_name(line)) return std::nullopt;
  const std::string name = api::printable(line.substr(line.starts_with('@') ? 1 : 0), kMostShown);
  const std::string shown_field = api::printable(field, kMostShown);
  const std::string argument = shown_field + "=@" + name;
  const bool quoted = argument.find(' ') != std::string::npos;
  return field_problem(api::ProblemKind::malformed_request, field.substr(0, 64),
                       "field '" + shown_field + "' holds the text '" + api::printable(line, kMostShown) +
                           "', not a file: write -F " + (quoted ? '"' + argument + '"' : argument));
}

}  // namespace meshgauge::server
