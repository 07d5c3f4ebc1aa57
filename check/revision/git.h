// Asks git, as a program of its own: by a vector of arguments, never by a shell.
#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

// For one thread at a time; blocks until git has ended, ten minutes at most. Errors are internal and say what git says:
// it is not installed, the folder is in no repository, or what the command does not find; or that it was interrupted.
// Nothing is fetched, and a bare repository is none, since its files may be tracked ones of another repository.
class Git {
 public:
  // Commands run in `folder`, which decides on the repository: GIT_DIR and the like are not passed on.
  explicit Git(std::filesystem::path folder, Interrupted interrupted = never_interrupted)
      : folder_(std::move(folder)), interrupted_(std::move(interrupted)) {}

  // Returns what the command prints, without the last line end. Precondition: no argument that comes from outside
  // begins with '-'.
  Result<std::string> output(const std::vector<std::string>& arguments) const;

  // The same for much: `read` is called once with the command's output; false ends the command. `input`: what it reads.
  using Read = std::function<bool(std::FILE* out)>;
  Result<Done> run(const std::vector<std::string>& arguments, std::string_view input, const Read& read) const;

 private:
  std::filesystem::path folder_;
  Interrupted interrupted_;
};

}  // namespace meshgauge::check
