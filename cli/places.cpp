#include "cli/places.h"

#include <sys/stat.h>

#include <system_error>

#include "api/base/refused.h"

namespace meshgauge::cli {
namespace {

// Returns the same string for every path of a file; of a file that does not exist, its canonical path.
std::string identity(const std::filesystem::path& file) {
  struct stat status {};
  if (stat(file.c_str(), &status) == 0) return std::to_string(status.st_dev) + ':' + std::to_string(status.st_ino);
  std::error_code failed;
  const auto place = std::filesystem::weakly_canonical(std::filesystem::absolute(file), failed);
  return failed ? file.string() : place.string();
}

}  // namespace

void Places::reads(const std::filesystem::path& file, const std::string& what) { taken_.emplace(identity(file), what); }

Result<Done> Places::writes(const std::string& flag, const std::filesystem::path& file) {
  const auto [place, is_new] = taken_.emplace(identity(file), "written by " + flag + " as well");
  if (is_new) return Done{};
  return bad_flag(flag, "'" + file.string() + "' is " + place->second + ": name another file");
}

}  // namespace meshgauge::cli
