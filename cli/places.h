// The files that a run reads and writes: nothing is written over what is read, or twice.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "engine/result.h"

namespace meshgauge::cli {

class Places {
 public:
  // `what` it is to the run: "the manifest". All of these come first.
  void reads(const std::filesystem::path& file, const std::string& what);

  // An Error that names `flag` when the file, by whatever name or link, is one of those above or written already.
  Result<Done> writes(const std::string& flag, const std::filesystem::path& file);

 private:
  std::map<std::string, std::string> taken_;  // what each is
};

}  // namespace meshgauge::cli
