#include "api/formats/file/file_path.h"

#include <algorithm>
#include <optional>

#include "api/base/text.h"
#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

std::optional<int> hex_value(char c) {
  if (is_digit(c)) return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return std::nullopt;
}

std::string percent_decoded(std::string_view uri) {
  std::string out;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto high = uri[i] == '%' && i + 2 < uri.size() ? hex_value(uri[i + 1]) : std::nullopt;
    const auto low = high ? hex_value(uri[i + 2]) : std::nullopt;
    out += low ? static_cast<char>(*high * 16 + *low) : uri[i];
    if (low) i += 2;
  }
  return out;
}

bool has_scheme(std::string_view name) {
  const std::size_t colon = name.find(':');
  if (colon == std::string_view::npos || colon == 0 || !is_letter(name.front())) return false;
  return std::ranges::all_of(name.substr(0, colon),
                             [](char c) { return is_letter(c) || is_digit(c) || c == '+' || c == '-' || c == '.'; });
}

// Returns the defect of the name as a whole; empty: none.
std::string defect_of(std::string_view name) {
  if (name.empty()) return "is empty";
  if (name.size() > kMostFilePathBytes) return "is longer than " + std::to_string(kMostFilePathBytes) + " bytes";
  if (find_control(name) != std::string_view::npos) return "has a control character";
  if (has_scheme(name)) return "has a scheme, and nothing is fetched: name a file in the folder of the .gltf";
  if (name.find('\\') != std::string_view::npos) return "has a backslash: folders are separated by '/'";
  if (name.front() == '/') return "is absolute: name a file in the folder of the .gltf";
  if (name.back() == '/') return "names a folder";
  return "";
}

}  // namespace

std::string file_key(std::string_view path) { return lower_case(std::string(path)); }

FilePath file_path_of_name(std::string_view name) {
  if (auto defect = defect_of(name); !defect.empty()) return {"", std::move(defect)};
  std::string path;
  std::size_t folders = 0;
  bool is_file = false;  // true: the last component may name a file
  while (!name.empty()) {
    const std::string_view component = name.substr(0, name.find('/'));
    name.remove_prefix(std::min(name.size(), component.size() + 1));
    if (component == "..") return {"", "has '..', which may lead out of the folder of the .gltf"};
    is_file = !component.empty() && component != ".";
    if (!is_file) continue;
    if (!path.empty()) path += '/', ++folders;
    path += component;
  }
  if (!is_file) return {"", "names a folder"};
  if (folders > kMostFilePathFolders) {
    return {"", "has more than " + std::to_string(kMostFilePathFolders) + " folders"};
  }
  if (file_key(path) == "_rels/.rels") return {"", "is the name of a part that every 3MF has: rename the file"};
  return {path, ""};
}

FilePath file_path_of_uri(std::string_view uri) { return file_path_of_name(percent_decoded(uri)); }

}  // namespace meshgauge::api
