#include "server/sandbox/become_reader.h"

#include <string_view>

#include <doctest/doctest.h>

#include "server/sandbox/processes.h"

using namespace meshgauge::server::sandbox;

namespace {

std::string become(std::string_view program) {
  char* no_arguments[] = {nullptr};
  return become_reader(std::as_bytes(std::span(program)), no_arguments);
}

}  // namespace

// That it becomes one is seen by the end-to-end tests.
TEST_CASE("become_reader: a failure returns why and leaves no descriptor open") {
  const std::size_t before = open_files();
  CHECK(become("").empty());
  CHECK(become("no program") == "no program in memory can be executed: Exec format error");
  CHECK(open_files() == before);
}
