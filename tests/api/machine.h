// A machine with control groups, for tests that read their limits.
#pragma once

#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>

// The files of a machine with the given control groups; the destructor deletes them.
struct Machine {
  std::string root = (std::filesystem::temp_directory_path() / "meshgauge-groups-XXXXXX").string();

  explicit Machine(const std::string& groups) {
    REQUIRE(::mkdtemp(root.data()) != nullptr);
    write("/proc/self/cgroup", groups);
  }
  ~Machine() { std::filesystem::remove_all(root); }
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  void write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(root + path).parent_path());
    std::ofstream(root + path) << text;
  }
};
