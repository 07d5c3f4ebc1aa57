// The results of a batch as they stream in, one a line.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>
#include <utility>

#include "check/remote/answer.h"

namespace meshgauge::check::service {

// Holds one line at a time, of kMostReplyBytes at most, and takes no more of them than the batch has comparisons:
// their positions rise. What stands behind the last end of a line is not believed.
class BatchResults {
 public:
  // `tell` may be called again for a position: each try begins with the first line.
  BatchResults(std::size_t comparisons, std::function<void(BatchLine)> tell)
      : comparisons_(comparisons), tell_(std::move(tell)) {}

  void begin();                       // before each try
  bool take(std::string_view piece);  // false: these cannot be the results of that batch

 private:
  bool take_line(std::string_view text);

  const std::size_t comparisons_;
  const std::function<void(BatchLine)> tell_;
  std::string line_;      // as far as it has come
  std::size_t next_ = 0;  // the lowest position that may come
};

}  // namespace meshgauge::check::service
