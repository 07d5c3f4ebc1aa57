#include "api/formats/geomview.h"

#include <algorithm>

#include "api/formats/off.h"
#include "api/formats/text.h"

namespace meshgauge::api {
namespace {

// Surfaces, curves and lists of them. Prefixes of letters tell what each vertex has; degrees follow BEZ.
constexpr std::string_view kObjects[] = {"LIST", "INST", "QUAD", "POLY",  "MESH",   "BEZ",
                                         "BBP",  "VECT", "SKEL", "GROUP", "SPHERE", "COMMENT"};
constexpr std::string_view kPrefixes = "STCNZ4Uuvn";
constexpr std::string_view kWords[] = {"appearance", "define", "geometry", "transform",
                                       "transforms", "camera", "image"};
constexpr std::size_t kLongest = 16;

std::string_view object_at(const char* p, const char* end) {
  const std::string_view word = word_at(p, std::min(end, p + std::min<std::ptrdiff_t>(end - p, kLongest)));
  if (std::ranges::find(kWords, word) != std::end(kWords)) return word;
  for (const std::string_view object : kObjects) {
    const std::size_t at = word.find(object);
    if (at == std::string_view::npos) continue;
    const bool prefixes_known = word.substr(0, at).find_first_not_of(kPrefixes) == std::string_view::npos;
    const bool degrees_follow = word.find_first_not_of("0123456789", at + object.size()) == std::string_view::npos;
    if (prefixes_known && degrees_follow) return word;
  }
  return {};
}

}  // namespace

std::string_view geomview_object(std::string_view text) {
  const char* const end = text.data() + text.size();
  if (!text.starts_with('{')) return object_at(text.data(), end);
  const std::string_view inner(start_of_content(text.substr(1)), end);
  const bool known = inner.starts_with('{') || inner.starts_with('=') || inner.starts_with('<') ||
                     !off_keyword(inner).empty() || !object_at(inner.data(), end).empty();
  return known ? text.substr(0, 1) : std::string_view();
}

}  // namespace meshgauge::api
