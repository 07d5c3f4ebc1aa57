// A folder of its own for a test, gone afterwards.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

namespace meshgauge::api::test {

namespace fs = std::filesystem;

// The smallest mesh that is read; `x` makes another one of it.
inline std::string small_mesh(int x = 1) {
  return "OFF\n3 1 0\n0 0 0\n" + std::to_string(x) + " 0 0\n0 1 0\n3 0 1 2\n";
}

class Folder {
 public:
  Folder() : path_(made()) {}
  ~Folder() {
    std::error_code none;
    fs::remove_all(path_, none);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  const fs::path& path() const { return path_; }
  fs::path operator/(const fs::path& name) const { return path_ / name; }

  // Folders on the way are made. Returns where it is.
  fs::path write(const fs::path& name, const std::string& text) const {
    fs::create_directories((path_ / name).parent_path());
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  std::string read(const fs::path& name) const {
    std::ifstream file(path_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

 private:
  static fs::path made() {
    std::string name = (fs::temp_directory_path() / "meshgauge-check-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no folder for a test");
    return fs::canonical(name);
  }

  fs::path path_;
};

// While it lives, a folder is the current one.
class Inside {
 public:
  explicit Inside(const fs::path& folder) : before_(fs::current_path()) { fs::current_path(folder); }
  ~Inside() { fs::current_path(before_); }
  Inside(const Inside&) = delete;
  Inside& operator=(const Inside&) = delete;

 private:
  fs::path before_;
};

}  // namespace meshgauge::api::test
