#include "server/http/head.h"

#include <algorithm>
#include <array>
#include <charconv>

#include "api/base/text.h"
#include "server/http/target.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using Refusal = std::optional<Problem>;

constexpr std::size_t kMaxRequestLineBytes = kMaxTargetBytes + 64;  // method, version, spaces
constexpr char kTlsHandshake = 0x16;                                // the first byte of a client that speaks TLS

// `authority`: set if the target names its host.
Refusal set_target(std::string_view text, Head& head, std::string& authority) {
  if (text.size() > kMaxTargetBytes) {
    return Problem{ProblemKind::uri_too_long,
                   "the request target is longer than " + std::to_string(kMaxTargetBytes) + " bytes"};
  }
  for (const char c : text) {
    if (c <= ' ' || c > '~' || c == '#')
      return malformed("the request target may hold visible ASCII characters only, without '#'");
  }
  const auto target = parse_target(text);
  if (!target || target->form == RequestTarget::Form::authority) {
    return malformed("the request target " + api::in_quotes(text) +
                     " must be a path that begins with '/', or an http URL; percent-encode what neither may hold");
  }
  head.path = target->path;
  head.query = target->query;
  authority = target->authority;
  return std::nullopt;
}

Refusal set_version(std::string_view version, Head& head) {
  if (version == "HTTP/1.1" || version == "HTTP/1.0") {
    head.minor_version = version.back() - '0';
    return std::nullopt;
  }
  if (version.starts_with("HTTP/")) {
    return Problem{ProblemKind::http_version, "unsupported HTTP version; send HTTP/1.1 or HTTP/1.0"};
  }
  return malformed("the request line must be 'METHOD TARGET HTTP/1.1'");
}

Refusal parse_request_line(std::string_view line, Head& head, std::string& authority) {
  constexpr std::array<std::string_view, 7> kKnown{"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"};
  head.method = next(line, " ");
  const std::string_view target = next(line, " ");
  if (!is_token(head.method)) return malformed("the request line must start with a method");
  if (auto refusal = set_version(line, head)) return refusal;
  if (auto refusal = set_target(target, head, authority)) return refusal;
  if (std::find(kKnown.begin(), kKnown.end(), head.method) == kKnown.end()) {
    return Problem{ProblemKind::not_implemented, "unknown method; known: " + api::listed(kKnown)};
  }
  if (head.path == "*" && head.method != "OPTIONS") return malformed("the request target '*' is for OPTIONS alone");
  return std::nullopt;
}

Refusal parse_field(std::string_view line, Head& head) {
  const std::size_t colon = line.find(':');
  if (colon == std::string_view::npos || !is_token(line.substr(0, colon))) {
    return malformed("header line " + std::to_string(head.headers.size() + 1) + " must be 'Name: value'");
  }
  const std::string_view value = trimmed(line.substr(colon + 1));
  if (!is_field_text(value)) {
    return malformed("header line " + std::to_string(head.headers.size() + 1) + " has a control character");
  }
  head.headers.emplace_back(lower(line.substr(0, colon)), value);
  return std::nullopt;
}

Refusal set_length(std::string_view text, std::uint64_t max_body_bytes, Head& head) {
  std::uint64_t length = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), length);
  const bool digits = !text.empty() && std::all_of(text.begin(), text.end(), is_digit);
  if (!digits) return malformed("Content-Length must be one decimal number");
  if (error != std::errc() || length > max_body_bytes) {
    return Problem{ProblemKind::too_large,
                   "the body is larger than the limit of " + std::to_string(max_body_bytes) + " bytes"};
  }
  head.content_length = length;
  return std::nullopt;
}

Refusal set_transfer_coding(std::string_view value, Head& head) {
  if (head.minor_version == 0) return malformed("Transfer-Encoding does not exist in HTTP/1.0");
  if (lower(value) != "chunked") {
    return Problem{ProblemKind::not_implemented, "unsupported Transfer-Encoding; the only one supported is 'chunked'"};
  }
  head.chunked = true;
  return std::nullopt;
}

Refusal set_content_coding(std::string_view value) {
  if (lower(value) == "identity") return std::nullopt;
  return Problem{ProblemKind::unsupported_media_type,
                 "Content-Encoding is not supported; a mesh file itself may be gzip-compressed"};
}

Refusal set_connection(std::string_view value, Head& head) {
  while (!value.empty()) {
    const std::string option = lower(trimmed(next(value, ",")));
    if (option == "close") head.keep_alive = false;
  }
  return std::nullopt;
}

Refusal interpret(const std::string& name, const std::string& value, std::uint64_t max_body_bytes, Head& head) {
  if (name == "content-length") return set_length(value, max_body_bytes, head);
  if (name == "transfer-encoding") return set_transfer_coding(value, head);
  if (name == "content-encoding") return set_content_coding(value);
  if (name == "connection") return set_connection(value, head);
  if (name == "expect") {
    if (lower(value) != "100-continue")
      return malformed("unsupported Expect; the only one supported is '100-continue'");
    head.expects_continue = head.minor_version > 0;
  }
  return std::nullopt;
}

std::size_t count(const Head& head, std::string_view name) {
  return static_cast<std::size_t>(
      std::count_if(head.headers.begin(), head.headers.end(), [&](const auto& field) { return field.first == name; }));
}

Refusal check_unique(const Head& head) {
  for (const char* name :
       {"content-length", "transfer-encoding", "content-type", "host", "expect", "authorization", "origin"}) {
    if (count(head, name) > 1) return malformed("the header '" + std::string(name) + "' was sent twice");
  }
  if (count(head, "content-length") + count(head, "transfer-encoding") > 1) {
    return malformed("Content-Length and Transfer-Encoding must not be sent together");
  }
  if (head.minor_version > 0 && count(head, "host") == 0) return malformed("the header 'Host' is missing");
  return std::nullopt;
}

// The host of a target replaces that of the header (RFC 9112 section 3.2.2).
Refusal set_host(const std::string& authority, Head& head) {
  const auto host =
      std::find_if(head.headers.begin(), head.headers.end(), [](const auto& field) { return field.first == "host"; });
  if (host != head.headers.end() && !parse_authority(host->second)) {
    return malformed("the header 'Host' must be a host name or an address, with or without a port, not " +
                     api::in_quotes(host->second));
  }
  if (authority.empty()) return std::nullopt;
  if (host != head.headers.end()) {
    host->second = authority;
  } else {
    head.headers.emplace_back("host", authority);
  }
  return std::nullopt;
}

Refusal check_length(const Head& head) {
  const bool carries = head.method == "POST" || head.method == "PUT" || head.method == "PATCH";
  if (!carries || head.chunked || head.content_length) return std::nullopt;
  return Problem{ProblemKind::length_required,
                 "the body has no length; send Content-Length or Transfer-Encoding: chunked"};
}

}  // namespace

Refusal parse_head(std::string_view text, std::uint64_t max_body_bytes, Head& head) {
  std::string authority;
  if (auto refusal = parse_request_line(next(text, "\r\n"), head, authority)) return refusal;
  head.keep_alive = head.minor_version > 0;
  for (std::string_view line = next(text, "\r\n"); !line.empty(); line = next(text, "\r\n")) {
    if (auto refusal = parse_field(line, head)) return refusal;
  }
  if (auto refusal = check_unique(head)) return refusal;
  if (auto refusal = set_host(authority, head)) return refusal;
  for (const auto& [name, value] : head.headers) {
    if (auto refusal = interpret(name, value, max_body_bytes, head)) return refusal;
  }
  return check_length(head);
}

std::string_view Head::header(std::string_view lower_case_name) const {
  for (const auto& [name, value] : headers) {
    if (name == lower_case_name) return value;
  }
  return {};
}

Refusal check_incomplete(std::string_view head) {
  if (head.starts_with(kTlsHandshake)) return malformed("this port speaks plain HTTP, not TLS: use http");
  if (head.find("\n\n") != std::string_view::npos) return malformed("lines of the head must end with CR LF");
  if (head.size() >= kMaxRequestLineBytes && head.find("\r\n") >= kMaxRequestLineBytes) {
    return Problem{ProblemKind::uri_too_long,
                   "the request target is longer than " + std::to_string(kMaxTargetBytes) + " bytes"};
  }
  if (head.size() < kMaxHeadBytes) return std::nullopt;
  return Problem{ProblemKind::head_too_large,
                 "the request's head is larger than " + std::to_string(kMaxHeadBytes) + " bytes"};
}

}  // namespace meshgauge::server
