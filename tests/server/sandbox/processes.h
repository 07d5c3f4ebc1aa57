// The processes that a test has started, as /proc shows them.
#pragma once

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

namespace meshgauge::server::sandbox {

struct Process {
  pid_t pid = 0;
  pid_t parent = 0;
  char state = '?';         // R: running, S: sleeping, Z: has ended and is not reaped
  unsigned long ticks = 0;  // of processor time, a hundredth of a second each
};

inline std::vector<Process> all_processes() {
  std::vector<Process> all;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream file(entry.path() / "stat");
    std::string text;
    std::getline(file, text);                 // nothing of a process that has just gone
    const std::size_t end = text.rfind(')');  // of the command's name, which may hold anything
    if (end == std::string::npos) continue;
    std::istringstream fields(text.substr(end + 1));
    Process process{std::stoi(name)};
    std::string skipped;
    fields >> process.state >> process.parent;
    for (int field = 5; field < 14; ++field) fields >> skipped;
    if (fields >> process.ticks) all.push_back(process);
  }
  return all;
}

inline std::vector<Process> children_of(pid_t parent) {
  std::vector<Process> all = all_processes();
  std::erase_if(all, [parent](const Process& p) { return p.parent != parent; });
  return all;
}

// The line of /proc/PID/status that begins with `name`, without it.
inline std::string status_line(pid_t pid, const std::string& name) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with(name + ":\t")) return line.substr(name.size() + 2);
  }
  return "";
}

inline std::vector<Process> spawners() { return children_of(::getpid()); }

inline std::vector<Process> workers() {
  std::vector<Process> all;
  for (const Process& spawner : spawners()) {
    const auto its = children_of(spawner.pid);
    all.insert(all.end(), its.begin(), its.end());
  }
  return all;
}

inline std::size_t open_files() {
  const auto files = std::filesystem::directory_iterator("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

}  // namespace meshgauge::server::sandbox
