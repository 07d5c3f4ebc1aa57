#pragma once

#include <filesystem>
#include <string>

#include "api/base/digest.h"

namespace meshgauge::server::store {

// A temporary folder that the destructor removes.
class TestFolder {
 public:
  TestFolder() : path_(std::filesystem::temp_directory_path() / ("meshgauge-store-" + api::random_id())) {
    std::filesystem::create_directory(path_);
  }
  ~TestFolder() { std::filesystem::remove_all(path_); }
  TestFolder(const TestFolder&) = delete;
  TestFolder& operator=(const TestFolder&) = delete;

  std::string operator/(const std::string& name) const { return (path_ / name).string(); }
  std::string path() const { return path_.string(); }

 private:
  std::filesystem::path path_;
};

}  // namespace meshgauge::server::store
