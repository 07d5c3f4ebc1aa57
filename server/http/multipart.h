// A streaming parser of multipart/form-data (RFC 7578). It buffers only the head of a field and what may be the start
// of a boundary.
//
// As RFC 2046 section 5.1.1 allows, it skips text before the first boundary (the preamble, up to kMaxPreambleBytes),
// text after the last one (the epilogue), and blanks that end the line of a boundary. What it skips holds no part: a
// boundary in it is refused, as are lines that end with LF alone.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/base/problem.h"

namespace meshgauge::server {

constexpr std::size_t kMaxPreambleBytes = std::size_t{8} << 10;

// The headers of one field of the form ("part" in RFC 7578).
struct FieldHead {
  std::string name;
  std::string filename;      // may be empty; chosen by the client, never opened as a path
  std::string content_type;  // may be empty
};

inline api::Problem field_problem(api::ProblemKind kind, const std::string& part, const std::string& what) {
  return {kind, what, {{part, "", what}}};
}

// Receives the fields of a form: begin(), data() any number of times, end(), for each. A refusal ends the parsing.
class MultipartSink {
 public:
  using Refusal = std::optional<api::Problem>;

  virtual ~MultipartSink() = default;
  virtual Refusal begin(const FieldHead& field) = 0;
  virtual Refusal data(std::string_view piece) = 0;
  virtual Refusal end() = 0;
};

// Sets `boundary` from a Content-Type. Returns a problem if it is not multipart/form-data, or has no valid boundary.
// `wanted`: what the message says that Content-Type must be.
std::optional<api::Problem> find_boundary(std::string_view content_type, const char* wanted, std::string& boundary);

class MultipartParser {
 public:
  using Refusal = std::optional<api::Problem>;

  MultipartParser(const std::string& boundary, MultipartSink& sink);  // borrows the sink

  // Parses the next bytes of the body. Returns nullopt, or the first problem, of the syntax or of the sink.
  Refusal feed(std::string_view bytes);
  Refusal finish() const;  // after the last byte: a problem if the closing boundary is missing

 private:
  enum class State { preamble, after_delimiter, padding, field_head, field_data, epilogue, after_epilogue };

  Refusal step(bool& stuck);
  Refusal take_preamble(bool& stuck);
  Refusal take_after_delimiter(bool& stuck);
  Refusal take_padding(bool& stuck);
  Refusal take_field_head(bool& stuck);
  Refusal take_field_data(bool& stuck);
  Refusal take_epilogue(bool& stuck);
  Refusal take_after_epilogue(bool& stuck);
  std::string_view dash_boundary() const { return std::string_view(delimiter_).substr(2); }
  Refusal after_the_end() const;
  std::string in_message(std::string_view end) const;  // dash_boundary() and `end` in quotes
  void consume(std::size_t n) { rest_.remove_prefix(n); }

  MultipartSink& sink_;
  std::string delimiter_;  // CR LF -- boundary
  State state_ = State::preamble;
  std::size_t preamble_ = 0;     // bytes of it that are consumed, with the first two of buffer_
  std::string buffer_ = "\r\n";  // so that a boundary at the start of the body begins a line, as every other one
  std::string_view rest_;        // the part of buffer_ that is not consumed yet
};

}  // namespace meshgauge::server
