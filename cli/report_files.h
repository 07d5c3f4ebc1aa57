// Writes the reports that `check` was asked for.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "check/outcome.h"
#include "cli/places.h"
#include "engine/result.h"

namespace meshgauge::cli {

class ReportFiles {
 public:
  using Write = std::function<std::string(const check::Report&)>;

  // `where`: a file, "-" for standard output, or empty: not wanted. `flag` names it in messages.
  void add(const std::string& flag, const std::string& where, Write write);

  // Checks before measuring and adds all files to `places`. Errors: two reports for standard output, a report over a
  // file of `places`, a folder that does not exist or is not writable.
  Result<Done> possible(Places& places) const;

  bool to_stdout() const;  // nothing else may be printed there

  // Writes all reports, also after a failure. Returns the first Error.
  Result<Done> write(const check::Report& report) const;

 private:
  struct Entry {
    std::string flag, where;
    Write write;
  };
  std::vector<Entry> entries_;
};

}  // namespace meshgauge::cli
