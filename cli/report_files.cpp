#include "cli/report_files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <utility>

#include "api/refused.h"

namespace meshgauge::cli {
namespace {

Error unwritable(const std::string& flag, const std::string& where, const std::string& why) {
  const std::string place = where == "-" ? "standard output" : "'" + where + "'";
  return bad_flag(flag, place + " " + why);
}

Error failed(const std::string& flag, const std::string& where) {
  return unwritable(flag, where, std::string("could not be written: ") + std::strerror(errno));
}

struct Closed {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

bool put(const std::string& text, std::FILE* out) {
  return std::fwrite(text.data(), 1, text.size(), out) == text.size() && std::fflush(out) == 0;
}

Result<Done> write_to(const std::string& flag, const std::string& where, const std::string& text) {
  if (where == "-") return put(text, stdout) ? Result<Done>(Done{}) : failed(flag, where);
  const std::unique_ptr<std::FILE, Closed> file(std::fopen(where.c_str(), "we"));
  if (!file || !put(text, file.get())) return failed(flag, where);
  return Done{};
}

Result<Done> has_folder(const std::string& flag, const std::string& where) {
  const std::filesystem::path path(where);
  std::error_code none;
  if (std::filesystem::is_directory(path, none)) return unwritable(flag, where, "is a folder: name a file in it");
  const auto folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, none))
    return unwritable(flag, where, "cannot be written: its folder does not exist");
  if (access(folder.c_str(), W_OK) != 0 && access(where.c_str(), W_OK) != 0) return failed(flag, where);
  return Done{};
}

}  // namespace

void ReportFiles::add(const std::string& flag, const std::string& where, Write write) {
  if (!where.empty()) entries_.push_back({flag, where, std::move(write)});
}

Result<Done> ReportFiles::possible(Places& places) const {
  const Entry* on_stdout = nullptr;
  for (const Entry& entry : entries_) {
    if (entry.where == "-") {
      if (on_stdout)
        return unwritable(entry.flag, entry.where, "is used by " + on_stdout->flag + " already: name a file");
      on_stdout = &entry;
      continue;
    }
    if (auto ok = has_folder(entry.flag, entry.where); !ok) return ok;
    if (auto ok = places.writes(entry.flag, entry.where); !ok) return ok;
  }
  return Done{};
}

bool ReportFiles::to_stdout() const {
  return std::any_of(entries_.begin(), entries_.end(), [](const Entry& entry) { return entry.where == "-"; });
}

Result<Done> ReportFiles::write(const check::Report& report) const {
  Result<Done> all = Done{};
  for (const Entry& entry : entries_) {
    auto written = write_to(entry.flag, entry.where, entry.write(report));
    if (!written && all) all = std::move(written);
  }
  return all;
}

}  // namespace meshgauge::cli
