// The head of a request: what is let through to the HTTP library, decided on bytes alone.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/problem.h"

namespace meshgauge::server {

inline constexpr std::size_t kMaxHeadBytes = std::size_t{16} << 10;
inline constexpr std::size_t kMaxTargetBytes = std::size_t{2} << 10;

// Of a request that is not understood.
inline api::Problem malformed(const std::string& what) { return {api::ProblemKind::malformed_request, what, {}}; }

struct Head {
  std::string method;
  std::string path;  // as sent, without the query; nothing is decoded
  std::string query;
  int minor_version = 1;                                     // of HTTP/1.x
  std::vector<std::pair<std::string, std::string>> headers;  // names in lower case
  std::optional<std::uint64_t> content_length;
  bool chunked = false;
  bool expects_continue = false;
  bool keep_alive = true;

  std::string_view header(std::string_view lower_case_name) const;  // the first of the name, or empty
};

// What a head that is still arriving already breaks: too long a line or head, lines without a CR.
std::optional<api::Problem> check_incomplete(std::string_view head);

// `text` ends with the empty line. Whatever two parsers could understand differently is refused: a bare CR or LF,
// a folded line, a space before the colon, Content-Length twice or beside Transfer-Encoding.
// `head` keeps what was understood before a refusal.
std::optional<api::Problem> parse_head(std::string_view text, std::uint64_t max_body_bytes, Head& head);

}  // namespace meshgauge::server
