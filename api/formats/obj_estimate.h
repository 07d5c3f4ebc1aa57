// How much room an OBJ will need.
#pragma once

#include <cstddef>
#include <string_view>

namespace meshgauge::api {

struct ObjEstimate {
  std::size_t vertices = 0;
  std::size_t faces = 0;
};

// From small windows spread over the file; nothing for a small one. Only a hint: one allocation of the right size
// instead of twenty that double, each with its copy and its page faults.
ObjEstimate estimate_obj(std::string_view text);

}  // namespace meshgauge::api
