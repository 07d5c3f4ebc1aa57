// A streaming parser of multipart/form-data (RFC 7578). It buffers only the head of a field and what may be the start
// of a boundary.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/problem.h"

namespace meshgauge::server {

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
  enum class State { start, after_delimiter, field_head, field_data, epilogue };

  Refusal step(bool& stuck);
  Refusal take_start(bool& stuck);
  Refusal take_after_delimiter(bool& stuck);
  Refusal take_field_head(bool& stuck);
  Refusal take_field_data(bool& stuck);
  void consume(std::size_t n) { rest_.remove_prefix(n); }

  MultipartSink& sink_;
  std::string delimiter_;  // CR LF -- boundary
  State state_ = State::start;
  std::string buffer_;
  std::string_view rest_;  // the part of buffer_ that is not consumed yet
};

}  // namespace meshgauge::server
