#include "server/http/target.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "api/base/text.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

constexpr std::string_view kUnreservedMarks = "-._~";
constexpr std::string_view kSubDelims = "!$&'()*+,;=";

bool is_hex_digit(char c) { return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); }

// Whether a URI may have the character in each of its parts, as itself.
bool is_uri_char(char c) {
  return is_letter(c) || is_digit(c) || kUnreservedMarks.find(c) != std::string_view::npos ||
         kSubDelims.find(c) != std::string_view::npos;
}

// Whether the text consists of such characters, those of `more`, and percent-encoded bytes.
bool is_part_of_uri(std::string_view text, std::string_view more) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%') {
      if (text.size() - i < 3 || !is_hex_digit(text[i + 1]) || !is_hex_digit(text[i + 2])) return false;
      i += 2;
    } else if (!is_uri_char(text[i]) && more.find(text[i]) == std::string_view::npos) {
      return false;
    }
  }
  return true;
}

// `family`: AF_INET or AF_INET6. inet_pton() takes what the grammar of RFC 3986 does: no leading zeros, no zone.
bool is_address_of(int family, std::string_view text) {
  in6_addr address{};  // large enough for both
  return text.find('\0') == std::string_view::npos && ::inet_pton(family, std::string(text).c_str(), &address) == 1;
}

// Removes "http://" or "https://", in any case, from the beginning. False: it has neither.
bool take_scheme(std::string_view& text) {
  const std::size_t end = text.find("://");
  if (end == std::string_view::npos) return false;
  const std::string_view scheme = text.substr(0, end);
  if (!api::same_word(scheme, "http") && !api::same_word(scheme, "https")) return false;
  text.remove_prefix(end + 3);
  return true;
}

bool has_host(const std::optional<Authority>& authority) { return authority && !authority->host.empty(); }

}  // namespace

std::optional<Authority> parse_authority(std::string_view text) {
  Authority authority;
  std::size_t end = 0;  // of the host
  if (text.starts_with('[')) {
    end = text.find(']');
    if (end == std::string_view::npos || !is_address_of(AF_INET6, text.substr(1, end - 1))) return std::nullopt;
    authority.kind = Authority::Kind::ipv6;
    ++end;
  } else {
    end = std::min(text.find(':'), text.size());
    if (!is_part_of_uri(text.substr(0, end), "")) return std::nullopt;
    if (is_address_of(AF_INET, text.substr(0, end))) authority.kind = Authority::Kind::ipv4;
  }
  authority.host = text.substr(0, end);
  text.remove_prefix(end);
  if (text.empty()) return authority;
  if (text.front() != ':') return std::nullopt;
  authority.port = text.substr(1);
  return std::all_of(authority.port.begin(), authority.port.end(), is_digit) ? std::optional(authority) : std::nullopt;
}

std::optional<RequestTarget> parse_target(std::string_view text) {
  RequestTarget target;
  if (text == "*") {
    target.form = RequestTarget::Form::asterisk;
    target.path = text;
    return target;
  }
  if (take_scheme(text)) {
    target.form = RequestTarget::Form::absolute;
    target.authority = text.substr(0, std::min(text.find_first_of("/?"), text.size()));
    if (!has_host(parse_authority(target.authority))) return std::nullopt;
    text.remove_prefix(target.authority.size());
  } else if (!text.starts_with('/')) {
    const auto authority = parse_authority(text);
    if (!has_host(authority) || authority->port.empty()) return std::nullopt;
    target.form = RequestTarget::Form::authority;
    target.authority = text;
    return target;
  }
  target.path = next(text, "?");
  target.query = text;
  if (!is_part_of_uri(target.path, ":@/") || !is_part_of_uri(target.query, ":@/?")) return std::nullopt;
  if (target.path.empty()) target.path = "/";
  return target;
}

}  // namespace meshgauge::server
