// Gates and files for the tests of check.
#pragma once

#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>

#include "check/gate.h"
#include "check/outcome.h"
#include "engine/mesh.h"
#include "tests/check/criteria.h"

namespace meshgauge::check {

// A folder that goes with the object.
class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "meshgauge-check-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  std::filesystem::path file(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }

  std::filesystem::path obj(const std::string& name, const Mesh& mesh) const {
    std::string text;
    char line[128];
    for (const Vec3& p : mesh.positions) {
      std::snprintf(line, sizeof line, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
      text += line;
    }
    for (const auto& t : mesh.triangles) {
      std::snprintf(line, sizeof line, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
      text += line;
    }
    return file(name, text);
  }

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

inline Gate gate(const std::filesystem::path& candidate, const std::filesystem::path& baseline, double max_distance) {
  Gate made;
  made.name = candidate.filename().string();
  made.candidate = candidate;
  made.baseline = baseline;
  set_limit(made, max_distance);
  return made;
}

// As measured_from() makes it, for a document of which nothing but the status is looked at.
inline Measured measured(double lower, double upper, double limit, const std::string& status = "gate_decided") {
  Measured made;
  made.document = {{"status", status}};
  set_criteria(made, {distance(lower, upper, limit, status)});
  return made;
}

}  // namespace meshgauge::check
