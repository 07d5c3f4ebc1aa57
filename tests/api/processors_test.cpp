#include "api/processors.h"

#include <doctest/doctest.h>
#include <sched.h>

#include <cstddef>

using meshgauge::api::usable_processors;

namespace {

// Lets this thread run on the first of its processors alone, as long as it lives.
class OnOneProcessor {
 public:
  OnOneProcessor() {
    REQUIRE(::sched_getaffinity(0, sizeof before_, &before_) == 0);
    std::size_t first = 0;
    while (!CPU_ISSET(first, &before_)) ++first;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    REQUIRE(::sched_setaffinity(0, sizeof one, &one) == 0);
  }
  ~OnOneProcessor() { ::sched_setaffinity(0, sizeof before_, &before_); }
  OnOneProcessor(const OnOneProcessor&) = delete;
  OnOneProcessor& operator=(const OnOneProcessor&) = delete;

 private:
  cpu_set_t before_{};
};

}  // namespace

TEST_CASE("processors: those that may be used, not those that the machine has") {
  const unsigned before = usable_processors();
  CHECK(before >= 1);
  {
    const OnOneProcessor one;
    CHECK(usable_processors() == 1);
  }
  CHECK(usable_processors() == before);
}
