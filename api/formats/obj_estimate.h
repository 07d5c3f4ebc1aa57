// Estimates the size of the mesh in an OBJ.
#pragma once

#include <cstddef>
#include <string_view>

namespace meshgauge::api {

struct ObjEstimate {
  std::size_t vertices = 0;
  std::size_t faces = 0;
};

// Estimates the counts from small windows spread over the file; zeros for a small file. A hint for allocation: one of
// about the right size replaces twenty that double, each with its copy and its page faults.
ObjEstimate estimate_obj(std::string_view text);

}  // namespace meshgauge::api
