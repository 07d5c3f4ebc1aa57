#include "api/base/roots.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include "api/base/json_filter.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

constexpr int kFolderFlags = O_RDONLY | O_DIRECTORY | O_CLOEXEC;

using Components = std::vector<std::string_view>;

// Leaves out empty ones and '.'.
Components components_of(std::string_view path) {
  Components all;
  while (!path.empty()) {
    const std::string_view one = path.substr(0, path.find('/'));
    path.remove_prefix(std::min(path.size(), one.size() + 1));
    if (!one.empty() && one != ".") all.push_back(one);
  }
  return all;
}

std::string path_of(const Components& components, std::size_t first) {
  std::string path;
  for (std::size_t i = first; i < components.size(); ++i) path.append(i == first ? "" : "/").append(components[i]);
  return path;
}

bool begins_with(const Components& path, const std::string& folder) {
  const Components above = components_of(folder);
  return above.size() < path.size() && std::equal(above.begin(), above.end(), path.begin());
}

bool has_file(const Descriptor& folder, const std::string& name) {
  struct stat status {};
  return ::fstatat(folder.get(), name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
}

// The path as it was given, absolute, where that names the folder: without its '..' one with links may not.
std::string written_path(const std::string& folder, const std::filesystem::path& real) {
  std::error_code failed;
  const auto path = std::filesystem::absolute(folder, failed).lexically_normal();
  return std::filesystem::canonical(path, failed) == real ? path.string() : real.string();
}

Error bad_path(std::string_view path, const std::string& why) {
  return refused("the path '" + std::string(path) + "' " + why);
}

}  // namespace

Result<Roots> Roots::open(const std::vector<std::string>& folders) {
  namespace fs = std::filesystem;
  Roots roots;
  for (const std::string& folder : folders) {
    std::error_code failed;
    const fs::path real = fs::canonical(folder, failed);
    auto held = std::make_shared<const Descriptor>(failed ? -1 : ::open(real.c_str(), kFolderFlags));
    if (!*held) return refused("'" + folder + "' is no folder that can be read");
    roots.folders_.push_back(real.string());
    roots.written_.push_back(written_path(folder, real));
    roots.held_.push_back(std::move(held));
  }
  return roots;
}

Result<Roots::Place> Roots::find(std::string_view path) const {
  if (path.empty()) return refused("the path is empty: name a file");
  if (find_control(path) != std::string_view::npos)
    return refused("the path " + shown_text(path) + " has a control character");
  const Components parts = components_of(path);
  if (std::ranges::find(parts, std::string_view("..")) != parts.end())
    return bad_path(path, "has '..', which may lead out of the folders that may be read");
  if (parts.empty()) return bad_path(path, "names a folder: name a file in it");
  if (path.front() == '/') {
    for (std::size_t i = 0; i < folders_.size(); ++i) {
      for (const std::string* folder : {&folders_[i], &written_[i]}) {
        if (begins_with(parts, *folder))
          return Place{{folders_[i], held_[i]}, path_of(parts, components_of(*folder).size())};
      }
    }
    return bad_path(path, "is outside of the folders that may be read: " + listed(folders_));
  }
  const std::string name = path_of(parts, 0);
  const auto first = std::ranges::find_if(held_, [&](const auto& held) { return has_file(*held, name); });
  const auto i = static_cast<std::size_t>(first == held_.end() ? 0 : first - held_.begin());
  return Place{{folders_[i], held_[i]}, name};
}

}  // namespace meshgauge::api
