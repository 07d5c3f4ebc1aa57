#include "api/formats/ply_values.h"

namespace meshgauge::api {
namespace {

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

}  // namespace

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

template class PlyBytes<std::endian::little>;
template class PlyBytes<std::endian::big>;

}  // namespace meshgauge::api
