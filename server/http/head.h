// Parses and validates the head of a request, before the HTTP library sees any of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/problem.h"

namespace meshgauge::server {

inline constexpr std::size_t kMaxHeadBytes = std::size_t{16} << 10;
inline constexpr std::size_t kMaxTargetBytes = std::size_t{2} << 10;

using api::malformed;

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

  std::string_view header(std::string_view lower_case_name) const;  // the first of that name; empty: none
};

// Returns the problem that a head which is still arriving has already: a line or head that is too long, or lines that
// end without CR. nullopt: none yet.
std::optional<api::Problem> check_incomplete(std::string_view head);

// Parses `text`, which ends with the empty line, into `head`. Returns nullopt or the problem; `head` then holds what
// was parsed before it. Rejects what two parsers could understand differently: a bare CR or LF, a folded line, a space
// before the colon, Content-Length twice or together with Transfer-Encoding, a target or a Host that the grammar
// (server/http/target.h) does not have. A target that names its host replaces Host. `max_body_bytes`: limit of
// Content-Length.
std::optional<api::Problem> parse_head(std::string_view text, std::uint64_t max_body_bytes, Head& head);

}  // namespace meshgauge::server
