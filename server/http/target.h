// The one parser of request targets and hosts, by the grammar of RFC 9112 section 3.2 and RFC 3986: for the routes, and
// for the check of the header Host. Nothing is decoded.
#pragma once

#include <optional>
#include <string_view>

namespace meshgauge::server {

// A host with its port: "gauge.example:443", "[::1]:8080". The views are parts of the text that was parsed.
struct Authority {
  enum class Kind { name, ipv4, ipv6 };

  Kind kind = Kind::name;
  std::string_view host;  // as sent; of an IPv6 address with its brackets; empty: a name of no character
  std::string_view port;  // digits; empty: none
};

// Parses uri-host [ ":" port ], the value of Host. Returns nullopt for anything else: a user before the host, text
// behind it, an IPv6 address without brackets or with a zone, an address of another version ("[v1.x]").
std::optional<Authority> parse_authority(std::string_view text);

// The target of a request. The views are parts of the text that was parsed, but for the path "/" of "http://host".
struct RequestTarget {
  enum class Form { origin, absolute, authority, asterisk };

  Form form = Form::origin;
  std::string_view authority;  // of the absolute and the authority form; else empty
  std::string_view path;       // with its first slash; "*" of the asterisk form; empty: of the authority form
  std::string_view query;      // without the question mark
};

// Parses the target of a request in any of its four forms: "/path?query", "http://host/path?query" (or https),
// "host:443" and "*". Returns nullopt for anything else: also for an absolute form with a user or without a host, and
// for a character that the grammar does not have in a path or query, such as '|' or a '%' without two hex digits.
std::optional<RequestTarget> parse_target(std::string_view text);

}  // namespace meshgauge::server
