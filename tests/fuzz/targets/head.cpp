// The head of a request, up to its empty line. Asserted of one that is let through: nothing in it could end a line
// somewhere else; its body has one length, within the limit; written anew from what was understood it is understood the
// same; no part of it was refused while it arrived.
#include <algorithm>
#include <array>
#include <string>

#include "server/http/head.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using server::Head;

constexpr std::uint64_t kMostBodyBytes = 1'000'000;

std::string written(const Head& head) {
  std::string text = head.method + ' ' + head.path + (head.query.empty() ? "" : '?' + head.query) + " HTTP/1." +
                     std::to_string(head.minor_version) + "\r\n";
  for (const auto& [name, value] : head.headers) text.append(name).append(": ").append(value).append("\r\n");
  return text + "\r\n";
}

bool same(const Head& a, const Head& b) {
  return a.method == b.method && a.path == b.path && a.query == b.query && a.minor_version == b.minor_version &&
         a.headers == b.headers && a.content_length == b.content_length && a.chunked == b.chunked &&
         a.expects_continue == b.expects_continue && a.keep_alive == b.keep_alive;
}

bool is_in_name(char c) { return c > ' ' && c <= '~' && c != ':' && !(c >= 'A' && c <= 'Z'); }

// To one reader of HTTP or another: any control character but the tab.
bool ends_a_line(char c) { return (static_cast<unsigned char>(c) < ' ' && c != '\t') || c == '\x7f'; }

void require_harmless(const Head& head) {
  const std::array<std::string_view, 7> known = {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
  require(std::count(known.begin(), known.end(), head.method) == 1, "the method is known", head.method);
  require(head.path == "*" || head.path.starts_with('/'), "the path starts with a slash", head.path);
  for (const char c : head.path + head.query) require(c > ' ' && c <= '~' && c != '#', "the target is visible ASCII");
  for (const auto& [name, value] : head.headers) {
    require(!name.empty() && std::ranges::all_of(name, is_in_name), "a name is a word in lower case", name);
    require(std::ranges::none_of(value, ends_a_line), "a value is on one line", value);
    require(!value.starts_with(' ') && !value.ends_with(' '), "a value is trimmed", value);
  }
  require(!head.chunked || (!head.content_length && head.minor_version == 1), "a body has one length");
  require(head.content_length.value_or(0) <= kMostBodyBytes, "a body's length is within the limit");
}

void require_accepted_in_parts(std::string_view text) {
  Dice dice = dice_of(text);
  for (int i = 0; i < 8; ++i) {
    const auto part = text.substr(0, dice.below(static_cast<std::uint32_t>(text.size())));
    require(!server::check_incomplete(part), "no part of a good head is refused", part);
  }
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(head) {
  using namespace meshgauge;
  const auto input = fuzz::text_of(data, size);
  const std::size_t end = input.substr(0, server::kMaxHeadBytes).find("\r\n\r\n");
  if (end == std::string_view::npos) {
    if (const auto refusal = server::check_incomplete(input)) fuzz::require_answer(*refusal);
    fuzz::require(size < server::kMaxHeadBytes || server::check_incomplete(input), "a head without an end is refused");
    return 0;
  }
  const std::string text(input.substr(0, end + 4));
  server::Head head;
  if (const auto refusal = server::parse_head(text, fuzz::kMostBodyBytes, head)) {
    fuzz::require_answer(*refusal);
    return 0;
  }
  fuzz::require_harmless(head);
  fuzz::require_accepted_in_parts(text.substr(0, end));
  server::Head again;
  const std::string anew = fuzz::written(head);
  fuzz::require(!server::parse_head(anew, fuzz::kMostBodyBytes, again) && fuzz::same(head, again),
                "a head written anew is understood the same", anew);
  return 0;
}
