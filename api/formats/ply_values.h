// Reads the values of a PLY body in order, from text or from bytes. Both classes have the same interface, for the
// reader in ply.cpp:
//
//   bool number(type, double&)      reads a coordinate; refuses NaN and infinity
//   bool integer(type, int64_t&)    reads a list's length or an index
//   bool skip(type, count)          skips unused values
//   bool end_record()               called after each record
//   bool end_body()                 called after the last record
//   size_t longer_records()         records with more values than the header announces
//   uint64_t most_records(element)  upper bound of the records that the remaining bytes can hold
//   bool fail(code, what)           sets error() at the last value, returns false
//
// false: error() has the defect.
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
  std::size_t longer_records() const { return longer_records_; }
  std::uint64_t most_records(const PlyElement& element) const;
  bool fail(ErrorCode code, const std::string& what);
  Error error() { return std::move(*error_); }

 private:
  bool next_word();

  const Source& source_;
  const char* p_;
  const char* last_;       // place of the last value
  std::string_view word_;  // the last value
  const char* end_;
  std::size_t longer_records_ = 0;
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
  std::size_t longer_records() const { return 0; }
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
