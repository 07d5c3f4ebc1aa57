// The values of a PLY body, one after another, from text or from bytes. Both kinds have the same face, on which
// the reader of ply.cpp is built:
//
//   bool number(type, double&)         a coordinate, finite
//   bool integer(type, int64_t&)       a list's length or an index
//   bool skip(type, count)             values that are not used
//   bool end_record()                  called after each record
//   uint64_t most_records(element)     how many records what remains can hold at most
//   Error fail(code, what), fail_here  about the last value, about the place reached
//
// A false return means that error() tells what is wrong.
#pragma once

#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "api/formats/ply_header.h"
#include "api/formats/text.h"

namespace meshgauge::api {

class PlyText {
 public:
  PlyText(const Source& source, const char* body)
      : source_(source), p_(skip_spaces(body, source.end())), last_(p_), end_(source.end()) {}

  bool number(PlyType type, double& value);
  bool integer(PlyType type, std::int64_t& value);
  bool skip(PlyType type, std::uint64_t count);
  bool end_record();
  bool end_body();
  std::uint64_t most_records(const PlyElement& element) const;
  bool fail(ErrorCode code, const std::string& what);
  Error error() { return std::move(*error_); }

 private:
  bool next_word();

  const Source& source_;
  const char* p_;
  const char* last_;       // the last value's place
  std::string_view word_;  // the last value
  const char* end_;
  std::optional<Error> error_;
};

template <std::endian Order>
class PlyBytes {
 public:
  PlyBytes(const Source& source, const char* body) : source_(source), p_(body), last_(body), end_(source.end()) {}

  bool number(PlyType type, double& value);
  bool integer(PlyType type, std::int64_t& value);
  bool skip(PlyType type, std::uint64_t count);
  bool end_record() { return true; }
  bool end_body();
  std::uint64_t most_records(const PlyElement& element) const { return remaining() / element.least_bytes(); }
  bool fail(ErrorCode code, const std::string& what);
  Error error() { return std::move(*error_); }

 private:
  std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - p_); }
  bool need(std::uint64_t bytes);

  template <class T>
  T load();

  const Source& source_;
  const char* p_;
  const char* last_;
  const char* end_;
  std::optional<Error> error_;
};

extern template class PlyBytes<std::endian::little>;
extern template class PlyBytes<std::endian::big>;

}  // namespace meshgauge::api
