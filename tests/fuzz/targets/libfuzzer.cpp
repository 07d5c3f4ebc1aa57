// The entry that libFuzzer calls, of the target that CMake names: one program a target.
#include "tests/fuzz/targets/target.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto run = meshgauge::fuzz::targets().at(MESHGAUGE_FUZZ_TARGET);
  return run(data, size);
}
