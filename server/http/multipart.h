// multipart/form-data (RFC 7578) as a stream: nothing is kept but the head of a part and the start of a boundary.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/problem.h"

namespace meshgauge::server {

struct FieldHead {
  std::string name;
  std::string filename;      // may be empty; from the client, not a path to open
  std::string content_type;  // may be empty
};

inline api::Problem field_problem(api::ProblemKind kind, const std::string& part, const std::string& what) {
  return {kind, what, {{part, "", what}}};
}

class MultipartSink {
 public:
  using Refusal = std::optional<api::Problem>;

  virtual ~MultipartSink() = default;
  virtual Refusal begin(const FieldHead& field) = 0;
  virtual Refusal data(std::string_view piece) = 0;
  virtual Refusal end() = 0;
};

// The boundary that a Content-Type names; a problem when it is not multipart/form-data or names none. `wanted`: what it
// must be, for that problem.
std::optional<api::Problem> find_boundary(std::string_view content_type, const char* wanted, std::string& boundary);

class MultipartParser {
 public:
  using Refusal = std::optional<api::Problem>;

  MultipartParser(const std::string& boundary, MultipartSink& sink);

  Refusal feed(std::string_view bytes);
  Refusal finish() const;  // a problem when the closing boundary has not been seen

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
  std::string_view rest_;  // of buffer_: not consumed yet
};

}  // namespace meshgauge::server
