// What gates ask of files.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

namespace meshgauge::check {

// What speaks against reading a file, behind its name: "does not exist"; nullopt: nothing.
std::optional<std::string> file_defect(const std::filesystem::path& file);

// Whether they are one file, links of both kinds included. What does not exist yet is compared by where it would be.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

// Whether `path` lies in `folder` or below; as they are written, links are not looked at.
bool is_below(const std::filesystem::path& path, const std::filesystem::path& folder);

// A file that is written beside its place and then put there, so that what is there is whole. Removed, unless it was.
class StagedFile {
 public:
  explicit StagedFile(std::filesystem::path place);
  StagedFile(StagedFile&& other) noexcept;
  StagedFile& operator=(StagedFile&&) = delete;
  ~StagedFile();

  const std::filesystem::path& path() const { return path_; }  // to be written, and closed
  const std::filesystem::path& place() const { return place_; }
  std::error_code put();

 private:
  std::filesystem::path path_;  // of a name that no other run has; empty: it was put
  std::filesystem::path place_;
};

std::string shown_path(const std::filesystem::path& path);  // for messages

}  // namespace meshgauge::check
