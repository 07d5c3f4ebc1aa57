#include "check/picture_name.h"

#include <cstddef>
#include <span>
#include <string_view>

#include "api/base/digest.h"
#include "api/base/text.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kSlugLetters = 72, kDigestDigits = 16;

bool is_sound(char c) { return api::is_letter(c) || api::is_digit(c); }

// Any other characters in a row are one '-'.
std::string slug_of(const std::string& name) {
  std::string slug;
  for (const char c : api::lower_case(name)) {
    const bool is_kept = is_sound(c) || c == '_' || c == '.';
    if (is_kept || slug.empty() || slug.back() != '-') slug += is_kept ? c : '-';
    if (slug.size() == kSlugLetters) break;
  }
  while (!slug.empty() && !is_sound(slug.back())) slug.pop_back();
  slug.erase(0, slug.find_first_of("abcdefghijklmnopqrstuvwxyz0123456789"));
  return slug;
}

// Such a name may be that of another gate's file.
bool ends_in_digest(const std::string& name) {
  const std::size_t dash = name.rfind('-');
  return api::is_lower_hex(std::string_view(name).substr(dash == std::string::npos ? 0 : dash + 1), kDigestDigits);
}

}  // namespace

std::string picture_name(const std::string& gate) {
  const std::string slug = slug_of(gate);
  if (slug == gate && !ends_in_digest(gate)) return slug + ".png";
  const std::string digest = api::sha256_hex(std::as_bytes(std::span(gate))).substr(0, kDigestDigits);
  return slug + (slug.empty() ? "" : "-") + digest + ".png";
}

}  // namespace meshgauge::check
