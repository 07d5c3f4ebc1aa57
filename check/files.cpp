#include "check/files.h"

#include <utility>

#include "api/base/digest.h"
#include "api/base/utf8.h"

namespace meshgauge::check {

namespace fs = std::filesystem;

std::optional<std::string> file_defect(const fs::path& file) {
  std::error_code failed;
  const fs::file_status status = fs::status(file, failed);
  if (status.type() == fs::file_type::not_found) return "does not exist";
  if (failed) return "cannot be read: " + failed.message();
  if (fs::is_directory(status)) return "is a folder: name a file in it, or all of them by '/*'";
  if (fs::is_fifo(status))
    return "is not a regular file but a pipe, which only the measurement of two meshes reads: write what it sends into "
           "a file";
  if (!fs::is_regular_file(status)) return "is not a regular file";
  return std::nullopt;
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code failed;
  if (fs::equivalent(a, b, failed)) return true;
  std::error_code failed_a, failed_b;
  return fs::weakly_canonical(a, failed_a) == fs::weakly_canonical(b, failed_b) && !failed_a && !failed_b;
}

bool is_below(const fs::path& path, const fs::path& folder) {
  const fs::path relative = path.lexically_relative(folder);
  return !relative.empty() && *relative.begin() != "..";
}

StagedFile::StagedFile(fs::path place)
    : path_(place.parent_path() / (".meshgauge-" + api::random_id() + ".part")), place_(std::move(place)) {}

StagedFile::StagedFile(StagedFile&& other) noexcept
    : path_(std::exchange(other.path_, {})), place_(std::move(other.place_)) {}

StagedFile::~StagedFile() {
  std::error_code none;
  if (!path_.empty()) fs::remove(path_, none);
}

std::error_code StagedFile::put() {
  std::error_code failed;
  fs::rename(path_, place_, failed);
  if (!failed) path_.clear();
  return failed;
}

std::string shown_path(const fs::path& path) {
  std::string out = "'";
  for (const char c : path.string()) out += is_control(c) ? '?' : c;
  return out + "'";
}

}  // namespace meshgauge::check
