// A fuzz target is a file with LLVMFuzzerTestOneInput(): built by clang with MESHGAUGE_FUZZERS it is a program of
// libFuzzer's, built by any compiler one that replays files (replay.cpp). It asserts more than that nothing crashes;
// what, stands at its top. docs/fuzzing.md tells how to run one and how to add one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace meshgauge::fuzz {

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace meshgauge::fuzz
