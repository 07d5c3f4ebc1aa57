// Parses the results of a batch while they stream in, one per line.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "check/remote/answer.h"

namespace meshgauge::check::service {

// Holds one line, of at most kMostReplyBytes, and accepts positions in rising order, at most as many as the batch has
// comparisons. Bytes after the last line end are ignored.
class BatchResults {
 public:
  // `tell` may be called again for a position: each try begins with the first line.
  BatchResults(std::size_t comparisons, std::function<void(BatchLine)> tell)
      : comparisons_(comparisons), tell_(std::move(tell)) {}

  void begin();                       // call before each try
  bool take(std::string_view piece);  // false: these are not the results of this batch

 private:
  bool take_line(std::string_view text);

  const std::size_t comparisons_;
  const std::function<void(BatchLine)> tell_;
  std::string line_;      // the incomplete line
  std::size_t next_ = 0;  // the lowest position that may follow
};

}  // namespace meshgauge::check::service
