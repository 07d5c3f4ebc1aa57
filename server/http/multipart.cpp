#include "server/http/multipart.h"

#include "server/http/head.h"
#include "server/http/parameters.h"
#include "server/http/text.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;
using Refusal = std::optional<Problem>;

constexpr std::size_t kMaxFieldHeadBytes = std::size_t{8} << 10;
constexpr std::size_t kMaxBoundaryBytes = 70;  // RFC 2046 section 5.1.1

bool read_disposition(std::string_view value, FieldHead& field) {
  if (take_kind(value) != "form-data") return false;
  return for_each_parameter(value, [&](const std::string& name, const std::string& text) {
    if (name == "name") field.name = text;
    if (name == "filename") field.filename = text;
  });
}

Refusal parse_field_head(std::string_view text, FieldHead& field) {
  bool named = false;
  while (!text.empty()) {
    std::string_view line = next(text, "\r\n");
    const std::string name = lower(next(line, ":"));
    const std::string_view value = trimmed(line);
    if (!is_token(name) || !is_field_text(value)) return malformed("a part's header must be 'Name: value'");
    if (name == "content-type") field.content_type = value;
    if (name == "content-disposition") named = read_disposition(value, field) && !field.name.empty();
  }
  if (named) return std::nullopt;
  return malformed("each part needs 'Content-Disposition: form-data; name=\"...\"'");
}

}  // namespace

Refusal find_boundary(std::string_view content_type, const char* wanted, std::string& boundary) {
  if (take_kind(content_type) != "multipart/form-data") {
    return Problem{ProblemKind::unsupported_media_type, std::string("Content-Type must be ") + wanted, {}};
  }
  const bool valid = for_each_parameter(content_type, [&](const std::string& name, const std::string& value) {
    if (name == "boundary") boundary = value;
  });
  if (valid && !boundary.empty() && boundary.size() <= kMaxBoundaryBytes) return std::nullopt;
  return malformed("Content-Type must name a boundary of 1 to " + std::to_string(kMaxBoundaryBytes) + " characters");
}

MultipartParser::MultipartParser(const std::string& boundary, MultipartSink& sink)
    : sink_(sink), delimiter_("\r\n--" + boundary) {}

Refusal MultipartParser::feed(std::string_view bytes) {
  buffer_.append(bytes);
  rest_ = buffer_;
  for (bool stuck = false; !stuck;) {
    if (auto refusal = step(stuck)) return refusal;
  }
  buffer_.erase(0, buffer_.size() - rest_.size());
  return std::nullopt;
}

Refusal MultipartParser::finish() const {
  if (state_ == State::epilogue) return std::nullopt;
  return malformed("the body ends before its closing boundary");
}

Refusal MultipartParser::step(bool& stuck) {
  switch (state_) {
    case State::start:
      return take_start(stuck);
    case State::after_delimiter:
      return take_after_delimiter(stuck);
    case State::field_head:
      return take_field_head(stuck);
    case State::field_data:
      return take_field_data(stuck);
    case State::epilogue:
      break;
  }
  consume(rest_.size());
  stuck = true;
  return std::nullopt;
}

Refusal MultipartParser::take_start(bool& stuck) {
  const std::string_view first = std::string_view(delimiter_).substr(2);
  stuck = rest_.size() < first.size();
  if (stuck) return std::nullopt;
  if (!rest_.starts_with(first)) return malformed("the body must start with the boundary that Content-Type names");
  consume(first.size());
  state_ = State::after_delimiter;
  return std::nullopt;
}

Refusal MultipartParser::take_after_delimiter(bool& stuck) {
  stuck = rest_.size() < 2;
  if (stuck) return std::nullopt;
  if (!rest_.starts_with("\r\n") && !rest_.starts_with("--"))
    return malformed("a boundary must be followed by CR LF or '--'");
  state_ = rest_.front() == '-' ? State::epilogue : State::field_head;
  consume(2);
  return std::nullopt;
}

Refusal MultipartParser::take_field_head(bool& stuck) {
  const std::size_t end = rest_.substr(0, kMaxFieldHeadBytes).find("\r\n\r\n");
  stuck = end == std::string_view::npos;
  if (stuck) {
    return rest_.size() >= kMaxFieldHeadBytes ? Refusal(malformed("a part's head is larger than 8192 bytes"))
                                              : std::nullopt;
  }
  FieldHead field;
  if (auto refusal = parse_field_head(rest_.substr(0, end), field)) return refusal;
  consume(end + 4);
  state_ = State::field_data;
  return sink_.begin(field);
}

Refusal MultipartParser::take_field_data(bool& stuck) {
  const std::size_t end = rest_.find(delimiter_);
  stuck = end == std::string_view::npos;
  // The last bytes may be the start of a delimiter: keep them until more arrive.
  const std::size_t certain = stuck ? rest_.size() - std::min(rest_.size(), delimiter_.size() - 1) : end;
  if (certain > 0) {
    if (auto refusal = sink_.data(rest_.substr(0, certain))) return refusal;
    consume(certain);
  }
  if (stuck) return std::nullopt;
  consume(delimiter_.size());
  state_ = State::after_delimiter;
  return sink_.end();
}

}  // namespace meshgauge::server
