// The files that a run reads and writes. No file is written over an input, or twice.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "engine/result.h"

namespace meshgauge::cli {

class Places {
 public:
  // `what` describes the file in messages: "the manifest". Call it for all inputs before writes().
  void reads(const std::filesystem::path& file, const std::string& what);

  // Errors name `flag`: the file, through any path or link, is an input or is already written.
  Result<Done> writes(const std::string& flag, const std::filesystem::path& file);

 private:
  std::map<std::string, std::string> taken_;  // file -> description
};

}  // namespace meshgauge::cli
