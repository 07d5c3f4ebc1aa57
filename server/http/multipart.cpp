#include "server/http/multipart.h"

#include "api/formats/file/source.h"
#include "server/http/head.h"
#include "server/http/head_values.h"
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
  bool disposed = false;
  while (!text.empty()) {
    std::string_view line = next(text, "\r\n");
    const std::string name = lower(next(line, ":"));
    const std::string_view value = trimmed(line);
    if (!is_token(name) || !is_field_text(value)) return malformed("a part's header must be 'Name: value'");
    if (name == "content-type") field.content_type = value;
    if (name != "content-disposition") continue;
    if (disposed) return malformed("the header 'Content-Disposition' of a part was sent twice");
    disposed = true;
    named = read_disposition(value, field) && !field.name.empty();
  }
  if (named) return std::nullopt;
  return malformed("each part needs 'Content-Disposition: form-data; name=\"...\"'");
}

}  // namespace

Refusal find_boundary(std::string_view content_type, const char* wanted, std::string& boundary) {
  const std::string kind = take_kind(content_type);
  if (kind != "multipart/form-data") {
    const std::string seen = kind.empty() ? "; the request has none" : ", not '" + api::printable(kind, 100) + "'";
    return Problem{ProblemKind::unsupported_media_type, std::string("Content-Type must be ") + wanted + seen};
  }
  bool named = false;
  const bool valid = for_each_parameter(content_type, [&](const std::string& name, const std::string& value) {
    if (name != "boundary") return;
    named = true;
    boundary = value;
  });
  if (!valid) {
    return malformed(
        "the parameters of Content-Type are malformed; write boundary=TEXT, and TEXT in double quotes if it has other "
        "characters than letters, digits and !#$%&'*+-.^_`|~");
  }
  if (!named) {
    return malformed(
        "Content-Type multipart/form-data lacks its parameter 'boundary': do not set Content-Type by hand; the HTTP "
        "library or curl -F writes it, with the boundary of the body");
  }
  if (!boundary.empty() && boundary.size() <= kMaxBoundaryBytes) return std::nullopt;
  return malformed("the boundary in Content-Type must have 1 to " + std::to_string(kMaxBoundaryBytes) +
                   " characters, not " + std::to_string(boundary.size()));
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
  if (state_ == State::after_epilogue) return after_the_end();
  if (state_ != State::preamble) return malformed("the body ends before its closing boundary " + in_message("--"));
  return malformed("no line of the body is " + in_message("") + ", the boundary that Content-Type names");
}

Refusal MultipartParser::step(bool& stuck) {
  switch (state_) {
    case State::preamble:
      return take_preamble(stuck);
    case State::after_delimiter:
      return take_after_delimiter(stuck);
    case State::padding:
      return take_padding(stuck);
    case State::field_head:
      return take_field_head(stuck);
    case State::field_data:
      return take_field_data(stuck);
    case State::epilogue:
      return take_epilogue(stuck);
    case State::after_epilogue:
      return take_after_epilogue(stuck);
  }
  return std::nullopt;
}

// A boundary within a line is refused: what follows could be a part, which would be skipped unsaid.
Refusal MultipartParser::take_preamble(bool& stuck) {
  const std::size_t at = rest_.find(dash_boundary());
  stuck = at == std::string_view::npos;
  // Kept: what may be the start of a boundary, and the two bytes before it.
  const std::size_t certain = stuck ? rest_.size() - std::min(rest_.size(), delimiter_.size() - 1) : at;
  preamble_ += certain;
  if (preamble_ > kMaxPreambleBytes + 2) {
    return malformed("no line of the body's first " + std::to_string(kMaxPreambleBytes) + " bytes is " +
                     in_message("") + ", the boundary that Content-Type names");
  }
  const bool begins_line = stuck || rest_.substr(0, at).ends_with("\r\n");
  if (!begins_line) {
    return malformed("the first boundary " + in_message("") + " comes after byte " + std::to_string(preamble_ - 2) +
                     " of the body, which does not end a line; a boundary begins a line, and lines end with CR LF");
  }
  consume(stuck ? certain : at + dash_boundary().size());
  if (!stuck) state_ = State::after_delimiter;
  return std::nullopt;
}

Refusal MultipartParser::take_after_delimiter(bool& stuck) {
  stuck = rest_.size() < 2;
  if (stuck) return std::nullopt;
  state_ = rest_.starts_with("--") ? State::epilogue : State::padding;
  if (state_ == State::epilogue) consume(2);
  return std::nullopt;
}

Refusal MultipartParser::take_padding(bool& stuck) {
  consume(std::min(rest_.size(), rest_.find_first_not_of(" \t")));
  stuck = rest_.size() < 2;
  if (stuck) return std::nullopt;
  if (!rest_.starts_with("\r\n")) {
    return malformed("the line of the boundary " + in_message("") +
                     " must end with CR LF, or with '--' after the last part");
  }
  state_ = State::field_head;
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

Refusal MultipartParser::take_epilogue(bool& stuck) {
  const std::size_t end = rest_.find(delimiter_);
  stuck = end == std::string_view::npos;
  consume(stuck ? rest_.size() - std::min(rest_.size(), delimiter_.size() - 1) : end + delimiter_.size());
  if (!stuck) state_ = State::after_epilogue;
  return std::nullopt;
}

// A client that closes each part would lose all but the first unsaid; a closing boundary twice loses nothing.
Refusal MultipartParser::take_after_epilogue(bool& stuck) {
  stuck = rest_.size() < 2;
  if (stuck) return std::nullopt;
  if (!rest_.starts_with("--")) return after_the_end();
  consume(2);
  state_ = State::epilogue;
  return std::nullopt;
}

Refusal MultipartParser::after_the_end() const {
  return malformed("a boundary comes after the closing one, " + in_message("--") + ", which ends the last part alone");
}

std::string MultipartParser::in_message(std::string_view end) const {
  return "'" + api::printable(std::string(dash_boundary()).append(end), kMaxBoundaryBytes + 4) + "'";
}

}  // namespace meshgauge::server
