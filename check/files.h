// Files of gates: checks before reading, and replacing a file as a whole.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

namespace meshgauge::check {

// Returns why the file cannot be read, as the end of a sentence ("does not exist"), or nullopt if it can.
std::optional<std::string> file_defect(const std::filesystem::path& file);

// Whether both paths name one file, through symbolic and hard links. A path that does not exist yet is compared by
// its canonical form.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Whether `path` is `folder` or below it, as the paths are written; links are not followed.
bool is_below(const std::filesystem::path& path, const std::filesystem::path& folder);

// A file written beside its final place and then renamed, so that the file there is always complete. The destructor
// removes a file that was not put.
class StagedFile {
 public:
  explicit StagedFile(std::filesystem::path place);
  StagedFile(StagedFile&& other) noexcept;
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile();

  const std::filesystem::path& path() const { return path_; }  // write this file and close it before put()
  const std::filesystem::path& place() const { return place_; }
  std::error_code put();

 private:
  std::filesystem::path path_;  // unique to this run; empty after put()
  std::filesystem::path place_;
};

std::string shown_path(const std::filesystem::path& path);  // quoted, control characters as '?'; for messages

}  // namespace meshgauge::check
