#include "api/formats/obj_estimate.h"

#include "api/formats/text.h"

namespace meshgauge::api {

ObjEstimate estimate_obj(std::string_view text) {
  constexpr std::size_t kWindows = 64;
  constexpr std::size_t kWindowBytes = 4096;
  if (text.size() < kWindows * kWindowBytes) return {};
  ObjEstimate found;
  for (std::size_t i = 0; i < kWindows; ++i) {
    const char* p = text.data() + (text.size() - kWindowBytes) / kWindows * i;
    for (const char* const end = p + kWindowBytes - 2; p < end; ++p) {
      found.vertices += is_newline(*p) && p[1] == 'v' && is_blank(p[2]);
      found.faces += is_newline(*p) && p[1] == 'f' && is_blank(p[2]);
    }
  }
  const double scale = 1.04 * static_cast<double>(text.size()) / static_cast<double>(kWindows * kWindowBytes);
  return {static_cast<std::size_t>(static_cast<double>(found.vertices) * scale),
          static_cast<std::size_t>(static_cast<double>(found.faces) * scale)};
}

}  // namespace meshgauge::api
