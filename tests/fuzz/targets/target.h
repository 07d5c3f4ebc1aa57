// A fuzz target is FUZZ_TARGET(name) { ... } in a file: a function of `data` and `size` that returns 0. Built by clang
// with MESHGAUGE_FUZZERS it becomes a program of libFuzzer's (libfuzzer.cpp); any compiler builds all of them into one
// program that replays files (replay.cpp). It asserts more than that nothing crashes; its file says what.
// docs/fuzzing.md tells how to run one and how to add one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string_view>

namespace meshgauge::fuzz {

using Target = int (*)(const std::uint8_t* data, std::size_t size);

// The targets of this program by name.
inline std::map<std::string_view, Target>& targets() {
  static std::map<std::string_view, Target> all;
  return all;
}

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

}  // namespace meshgauge::fuzz

#define FUZZ_TARGET(name)                                                                               \
  static int target_##name(const std::uint8_t* data, std::size_t size);                                 \
  static const bool is_listed_##name = meshgauge::fuzz::targets().emplace(#name, target_##name).second; \
  static int target_##name([[maybe_unused]] const std::uint8_t* data, [[maybe_unused]] std::size_t size)
