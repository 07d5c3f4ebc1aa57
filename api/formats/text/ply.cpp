#include "api/formats/file/readers.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "api/base/text.h"
#include "api/formats/file/source.h"
#include "api/formats/polygons/polygons.h"
#include "api/formats/text/ply_header.h"
#include "api/formats/text/ply_plain.h"

namespace meshgauge::api {
namespace {

// PlyText and PlyBytes read the values of a body in order, from text and from bytes. Both have the same interface:
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
// false: error() has the defect. kPlain: the body is bytes that plain records (ply_plain.h) are read from, at place();
// advance() passes over what was read so.

class PlyText {
 public:
  static constexpr bool kPlain = false;

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
  static constexpr bool kPlain = Order == std::endian::little;

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

  const char* place() const { return p_; }
  std::uint64_t remaining() const { return static_cast<std::uint64_t>(end_ - p_); }
  // `last_bytes`: of the last value. Precondition: 0 < last_bytes <= bytes <= remaining().
  void advance(std::uint64_t bytes, std::size_t last_bytes) {
    p_ += bytes;
    last_ = p_ - last_bytes;
  }

 private:
  bool need(std::uint64_t bytes);

  template <class T>
  T load();

  const Source& source_;
  const char* p_;
  const char* last_;
  const char* end_;
  std::optional<Error> error_;
};

template <class T>
T from_order(const char* p, std::endian order) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, p, sizeof(T));
  if (order != std::endian::native) {
    for (std::size_t i = 0; i < sizeof(T) / 2; ++i) std::swap(bytes[i], bytes[sizeof(T) - 1 - i]);
  }
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

bool PlyText::fail(ErrorCode code, const std::string& what) {
  error_ = at_line(source_, last_, code, what);
  return false;
}

bool PlyText::next_word() {
  last_ = p_ = skip_blanks(p_, end_);
  word_ = word_at(p_, end_);
  p_ += word_.size();
  if (!word_.empty()) [[likely]]
    return true;
  return fail(ErrorCode::unreadable_mesh, p_ == end_ ? "truncated: the header announces more values"
                                                     : "the line ends before all the values that the header announces");
}

bool PlyText::number(PlyType /*type*/, double& value) {
  if (!next_word()) return false;
  if (parse_number(word_.data(), p_, value) != p_) {
    return fail(ErrorCode::unreadable_mesh, in_quotes(word_) + " is not a number");
  }
  return std::isfinite(value) ||
         fail(ErrorCode::non_finite_vertex, "the coordinate " + in_quotes(word_) + " is not finite");
}

bool PlyText::integer(PlyType /*type*/, std::int64_t& value) {
  if (!next_word()) return false;
  if (parse_integer(word_.data(), p_, value) == p_) return true;
  return fail(ErrorCode::unreadable_mesh, in_quotes(word_) + " is not an integer");
}

bool PlyText::skip(PlyType /*type*/, std::uint64_t count) {
  for (; count > 0; --count) {
    if (!next_word()) return false;
  }
  return true;
}

// Skips to the next line: one record per line. Some files have values that the header does not announce at the end of
// their lines, where they do not shift other values.
bool PlyText::end_record() {
  const char* const line_end = skip_line(p_, end_);
  longer_records_ += skip_spaces(p_, line_end) != line_end;
  p_ = skip_spaces(line_end, end_);
  return true;
}

bool PlyText::end_body() {
  last_ = p_;
  return p_ == end_ || fail(ErrorCode::unreadable_mesh, "left-over text after the last element");
}

// Every value takes at least a character and a space; the last one needs no space.
std::uint64_t PlyText::most_records(const PlyElement& element) const {
  return (static_cast<std::uint64_t>(end_ - p_) + 1) / (2 * element.properties.size());
}

template <std::endian Order>
bool PlyBytes<Order>::fail(ErrorCode code, const std::string& what) {
  error_ = at_byte(source_, static_cast<std::size_t>(last_ - source_.begin()), code, what);
  return false;
}

template <std::endian Order>
bool PlyBytes<Order>::need(std::uint64_t bytes) {
  last_ = p_;
  if (bytes <= remaining()) [[likely]]
    return true;
  return fail(ErrorCode::unreadable_mesh, "truncated: " + std::to_string(bytes) + " bytes are needed here, " +
                                              std::to_string(remaining()) + " remain");
}

template <std::endian Order>
template <class T>
T PlyBytes<Order>::load() {
  const T value = from_order<T>(p_, Order);
  p_ += sizeof(T);
  return value;
}

template <std::endian Order>
bool PlyBytes<Order>::integer(PlyType type, std::int64_t& value) {
  if (!need(size_of(type))) return false;
  switch (type) {
    case PlyType::int8:
      value = load<std::int8_t>();
      break;
    case PlyType::uint8:
      value = load<std::uint8_t>();
      break;
    case PlyType::int16:
      value = load<std::int16_t>();
      break;
    case PlyType::uint16:
      value = load<std::uint16_t>();
      break;
    case PlyType::int32:
      value = load<std::int32_t>();
      break;
    case PlyType::uint32:
      value = load<std::uint32_t>();
      break;
    default:
      return fail(ErrorCode::internal, "a float where an integer is read");
  }
  return true;
}

template <std::endian Order>
bool PlyBytes<Order>::number(PlyType type, double& value) {
  if (is_integer(type)) {
    std::int64_t exact = 0;
    if (!integer(type, exact)) return false;
    value = static_cast<double>(exact);
    return true;
  }
  if (!need(size_of(type))) return false;
  value = type == PlyType::float32 ? static_cast<double>(load<float>()) : load<double>();
  return std::isfinite(value) || fail(ErrorCode::non_finite_vertex, "a coordinate is not finite");
}

template <std::endian Order>
bool PlyBytes<Order>::skip(PlyType type, std::uint64_t count) {
  const std::uint64_t bytes = count * size_of(type);  // count is below 2^32
  if (!need(bytes)) return false;
  p_ += bytes;
  return true;
}

template <std::endian Order>
bool PlyBytes<Order>::end_body() {
  last_ = p_;
  // Some writers add a line end.
  return skip_spaces(p_, end_) == end_ ||
         fail(ErrorCode::unreadable_mesh, std::to_string(remaining()) + " left-over bytes after the last element");
}

template <class Values>
class BodyReader {
 public:
  BodyReader(const Source& source, const PlyHeader& header, const PlyLayout& layout)
      : source_(source),
        header_(header),
        layout_(layout),
        values_(source, header.body),
        faces_(out_.mesh.triangles),
        strip_(out_.mesh.triangles) {
    out_.format = Format::ply;
    out_.unread = layout.unread;
    out_.notes.skipped_primitives = layout.lines;
  }

  Result<ReadMesh> read();

 private:
  bool element(const PlyElement& element);
  bool vertices(const PlyElement& element);
  bool take_plain_vertices(const PlyElement& element);
  std::uint64_t take_plain_triangles(const PlainFaces& faces, std::uint64_t most);
  bool records(const PlyElement& element);
  bool face(const PlyProperty& property);
  bool strips(const PlyProperty& property);
  bool in_range(std::int64_t index);
  bool within_limit();
  bool skip(const PlyProperty& property);
  bool skip_and_count(const PlyProperty& property, std::size_t& filled);
  bool list_length(const PlyProperty& property, std::int64_t& length);
  void add_remarks();

  const Source& source_;
  const PlyHeader& header_;
  const PlyLayout& layout_;
  Values values_;
  ReadMesh out_;
  Faces faces_;
  Strip strip_;
};

template <class Values>
bool BodyReader<Values>::list_length(const PlyProperty& property, std::int64_t& length) {
  if (!values_.integer(property.count_type, length)) return false;
  if (length >= 0 && length <= std::int64_t{0xFFFFFFFF}) return true;
  return values_.fail(ErrorCode::unreadable_mesh, std::to_string(length) + " is not a valid length of a list");
}

template <class Values>
bool BodyReader<Values>::skip(const PlyProperty& property) {
  if (!property.is_list) return values_.skip(property.type, 1);
  std::int64_t length = 0;
  return list_length(property, length) && values_.skip(property.type, static_cast<std::uint64_t>(length));
}

// Returns false when not all vertices are plain and finite; then it has read nothing.
template <class Values>
bool BodyReader<Values>::take_plain_vertices(const PlyElement& element) {
  const auto plain = plain_vertices(element);
  if (!plain || element.count == 0) return false;
  std::vector<Vec3>& positions = out_.mesh.positions;
  positions.resize(element.count);  // Vec3 is not initialised, so this writes nothing
  if (!read_vertices(values_.place(), *plain, element.count, positions.data())) {
    positions.clear();
    return false;
  }
  values_.advance(element.count * plain->record_bytes, size_of(element.properties.back().type));
  return true;
}

template <class Values>
bool BodyReader<Values>::vertices(const PlyElement& element) {
  // The coordinate of each property: 0 to 2; 3: none.
  std::vector<int> axes;
  for (const PlyProperty& property : element.properties) {
    const std::size_t axis = property.name.size() == 1 ? std::string_view("xyz").find(property.name) : 3;
    axes.push_back(axis < 3 ? static_cast<int>(axis) : 3);
  }
  reserve_room(out_.mesh.positions, element.count);
  if constexpr (Values::kPlain) {
    if (take_plain_vertices(element)) return true;
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    Vec3 position;
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      const bool ok = axes[k] < 3 ? values_.number(property.type, position[axes[k]]) : skip(property);
      if (!ok) return false;
    }
    if (!values_.end_record()) return false;
    out_.mesh.positions.push_back(position);
  }
  return true;
}

template <class Values>
bool BodyReader<Values>::in_range(std::int64_t index) {
  const std::uint64_t count = layout_.vertex->count;
  if (index >= 0 && static_cast<std::uint64_t>(index) < count) [[likely]]
    return true;
  return values_.fail(ErrorCode::index_out_of_range,
                      "index " + std::to_string(index) + ", but there are " + std::to_string(count) + " vertices");
}

// Called after every corner: a list of single bytes becomes twelve times its size in memory.
template <class Values>
bool BodyReader<Values>::within_limit() {
  if (out_.mesh.triangles.size() <= source_.limits.max_triangles) [[likely]]
    return true;
  return values_.fail(ErrorCode::too_large,
                      "more triangles than the limit of " + std::to_string(source_.limits.max_triangles));
}

template <class Values>
bool BodyReader<Values>::face(const PlyProperty& property) {
  std::int64_t length = 0;
  if (!list_length(property, length)) return false;
  // Misaligned bytes, for example after a wrong count of vertices, first show as empty faces.
  if (length == 0) return values_.fail(ErrorCode::unreadable_mesh, "a face without corners");
  faces_.begin();
  for (std::int64_t corner = 0; corner < length; ++corner) {
    std::int64_t index = 0;
    if (!values_.integer(property.type, index) || !in_range(index)) return false;
    faces_.add(static_cast<std::uint32_t>(index));
    if (!within_limit()) return false;
  }
  out_.notes.skipped_primitives += length < 3;
  faces_.end();
  return true;
}

// Reads any number of strips, separated by -1.
template <class Values>
bool BodyReader<Values>::strips(const PlyProperty& property) {
  std::int64_t length = 0;
  if (!list_length(property, length)) return false;
  const auto end_strip = [&] {
    out_.notes.skipped_primitives += strip_.corners() == 1 || strip_.corners() == 2;
    strip_.begin();
  };
  for (std::int64_t corner = 0; corner < length; ++corner) {
    std::int64_t index = 0;
    if (!values_.integer(property.type, index)) return false;
    if (index == -1) {
      end_strip();
      continue;
    }
    if (!in_range(index)) return false;
    strip_.add(static_cast<std::uint32_t>(index));
    if (!within_limit()) return false;
  }
  end_strip();
  return true;
}

// Counts the lists that are not empty.
template <class Values>
bool BodyReader<Values>::skip_and_count(const PlyProperty& property, std::size_t& filled) {
  std::int64_t length = 0;
  if (!list_length(property, length)) return false;
  filled += length > 0;
  return values_.skip(property.type, static_cast<std::uint64_t>(length));
}

// Returns how many of the next records were plain triangles, which it has read.
template <class Values>
std::uint64_t BodyReader<Values>::take_plain_triangles(const PlainFaces& faces, std::uint64_t most) {
  std::vector<Triangle>& triangles = out_.mesh.triangles;
  if (triangles.size() >= source_.limits.max_triangles) return 0;
  most = std::min<std::uint64_t>(
      {most, values_.remaining() / faces.triangle_bytes, source_.limits.max_triangles - triangles.size()});
  const std::uint64_t read = read_triangles(values_.place(), faces, most, layout_.vertex->count, triangles);
  if (read > 0) values_.advance(read * faces.triangle_bytes, faces.last_bytes);
  return read;
}

template <class Values>
bool BodyReader<Values>::records(const PlyElement& element) {
  const bool has_faces = element.name == "face" || element.name == "tristrips";
  std::vector<std::size_t> unread(element.properties.size());
  const auto plain = plain_faces(element, layout_.face_corners);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    if constexpr (Values::kPlain) {
      if (plain) i += take_plain_triangles(*plain, element.count - i);
      if (i == element.count) break;
    }
    for (std::size_t k = 0; k < unread.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      const bool ok = &property == layout_.face_corners    ? face(property)
                      : &property == layout_.strip_corners ? strips(property)
                      : property.is_list                   ? skip_and_count(property, unread[k])
                                                           : skip(property);
      if (!ok) return false;
    }
    if (!values_.end_record()) return false;
  }
  for (std::size_t k = 0; k < unread.size(); ++k) {
    const PlyProperty& property = element.properties[k];
    if (!has_faces || unread[k] == 0 || !may_hold_corners(property)) continue;
    out_.unread.add("lists " + in_quotes(property.name) + " of element " + in_quotes(element.name), unread[k]);
  }
  return true;
}

template <class Values>
bool BodyReader<Values>::element(const PlyElement& element) {
  if (element.properties.empty()) return true;  // records of no bytes, in any number
  if (element.count > values_.most_records(element)) {
    return values_.fail(ErrorCode::unreadable_mesh, "truncated: " + std::to_string(element.count) +
                                                        " records of element " + in_quotes(element.name) +
                                                        " do not fit into what remains");
  }
  if (&element == layout_.vertex) return vertices(element);
  if (element.name == "face") reserve_room(out_.mesh.triangles, element.count);
  return records(element);
}

template <class Values>
void BodyReader<Values>::add_remarks() {
  if (header_.unknown_lines != 0) {
    out_.notes.remarks.push_back("header lines that begin with an unknown word, ignored: " +
                                 std::to_string(header_.unknown_lines) + ", the first with " + header_.first_unknown);
  }
  out_.notes.add_remark("lines with more values than the header announces, the others ignored",
                        values_.longer_records());
}

template <class Values>
Result<ReadMesh> BodyReader<Values>::read() {
  if (layout_.vertex->count > vertex_limit(source_)) return too_many(source_, "vertices", vertex_limit(source_));
  for (const PlyElement& next : header_.elements) {
    if (!element(next)) return values_.error();
  }
  if (!values_.end_body()) return values_.error();
  out_.notes.skipped_primitives += strip_.joins();
  add_remarks();
  if (auto split = split_polygons(source_, faces_.runs(), out_); !split) return std::move(split).error();
  if (out_.mesh.triangles.empty() && out_.notes.skipped_primitives == 0 && layout_.only_points) {
    if (auto ok = make_cloud(source_, out_); !ok) return std::move(ok).error();
  }
  return std::move(out_);
}

template <class Values>
Result<ReadMesh> read_body(const Source& source, const PlyHeader& header) {
  const auto layout = find_layout(source, header);
  if (!layout) return layout.error();
  return BodyReader<Values>(source, header, *layout).read();
}

// Reads the header again, since padding may begin within it.
Result<ReadMesh> read_ascii(const Source& source) {
  const auto header = read_ply_header(source);
  return header ? read_body<PlyText>(source, *header) : header.error();
}

}  // namespace

Result<ReadMesh> read_ply(const Source& source) {
  const auto header = read_ply_header(source);
  if (!header) return header.error();
  switch (header->encoding) {
    case PlyEncoding::ascii:
      return read_without_padding(source, read_ascii);
    case PlyEncoding::little_endian:
      return read_body<PlyBytes<std::endian::little>>(source, *header);
    case PlyEncoding::big_endian:
      break;
  }
  return read_body<PlyBytes<std::endian::big>>(source, *header);
}

}  // namespace meshgauge::api
