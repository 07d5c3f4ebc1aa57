// The reports that `check` writes, and where to.
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

  // `where`: a file, "-" for standard output, or empty: then the report is not asked for. `flag` names it in messages.
  void add(const std::string& flag, const std::string& where, Write write);

  // Before anything is measured: an Error when two reports are to share standard output, when one is to be written over
  // a file of `places`, which gets all of them, or when there is no folder to write to.
  Result<Done> possible(Places& places) const;

  bool to_stdout() const;  // so that nothing else may go there

  // Writes all of them, also when one fails: the first Error.
  Result<Done> write(const check::Report& report) const;

 private:
  struct Entry {
    std::string flag, where;
    Write write;
  };
  std::vector<Entry> entries_;
};

}  // namespace meshgauge::cli
