#include "server/sandbox/protocol.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <iterator>
#include <limits>
#include <utility>

namespace meshgauge::server::sandbox {
namespace {

constexpr std::size_t kMostHint = 1024;
constexpr std::size_t kMostText = 4096;
constexpr std::uint64_t kMesh = 1;
constexpr std::uint64_t kError = 2;

class Writer {
 public:
  Writer& number(std::uint64_t value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Writer& length(double value) { return number(std::bit_cast<std::uint64_t>(value)); }
  Writer& text(std::string_view value) {
    number(value.size());
    bytes_ += value;
    return *this;
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_;
};

// Reads numbers and texts in order. After the first missing one all others are zero and complete() is false.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : rest_(bytes) {}

  // Reads a length: finite and at least 0.
  double length() {
    const double value = std::bit_cast<double>(number());
    if (value >= 0 && value <= std::numeric_limits<double>::max()) return value;
    ok_ = false;
    return 0;
  }
  std::uint64_t number() {
    std::uint64_t value = 0;
    const std::string_view bytes = take(sizeof value);
    if (!bytes.empty()) std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  // Reads a number from 0 to `most`.
  std::uint64_t number(std::uint64_t most) {
    const std::uint64_t value = number();
    if (value <= most) return value;
    ok_ = false;
    return 0;
  }
  std::string text(std::size_t most) {
    const std::uint64_t size = number(most);
    return std::string(take(size));
  }
  std::size_t left() const { return rest_.size(); }
  bool complete() const { return ok_ && rest_.empty(); }

 private:
  std::string_view take(std::uint64_t size) {
    if (!ok_ || size > rest_.size()) {
      ok_ = false;
      return {};
    }
    const std::string_view taken = rest_.substr(0, size);
    rest_.remove_prefix(size);
    return taken;
  }

  std::string_view rest_;
  bool ok_ = true;
};

std::string_view end_of(std::string_view hint) { return hint.substr(hint.size() - std::min(hint.size(), kMostHint)); }

bool is_format(std::uint64_t number) { return number <= static_cast<std::uint64_t>(api::Format::xyz); }
bool is_unit(std::uint64_t number) { return number < std::size(api::kLengthUnits); }

// Whether a reader may return this code. A worker stores nothing, so storage errors are excluded.
bool is_error_code(std::uint64_t number) {
  static constexpr std::array kGiven{ErrorCode::unsupported_format, ErrorCode::unreadable_mesh,
                                     ErrorCode::empty_mesh,         ErrorCode::non_finite_vertex,
                                     ErrorCode::index_out_of_range, ErrorCode::coordinate_too_large,
                                     ErrorCode::too_large,          ErrorCode::internal};
  return std::ranges::find(kGiven, static_cast<ErrorCode>(number)) != kGiven.end();
}

// Covers every enumerator; no cast to an enumeration loses a digit.
constexpr std::uint64_t kMostEnumerator = 255;

// Encoding of an optional enumerator: 0 for none, otherwise the enumerator plus 1.
template <class Enumeration>
std::uint64_t number_of(std::optional<Enumeration> value) {
  return value ? static_cast<std::uint64_t>(*value) + 1 : 0;
}

template <class Enumeration>
bool take(Reader& reader, bool (*is_one)(std::uint64_t), std::optional<Enumeration>& value) {
  const std::uint64_t number = reader.number(kMostEnumerator);
  if (number == 0) return true;
  value = static_cast<Enumeration>(number - 1);
  return is_one(number - 1);
}

void put(Writer& writer, const api::ReadNotes& notes) {
  static_assert(sizeof notes == 128, "a new note must be sent, and taken in take_notes()");
  const api::PolygonNotes& polygons = notes.polygons;
  writer.number(notes.gzip ? 1 : 0)
      .number(notes.cloud ? 1 : 0)
      .number(polygons.count)
      .number(polygons.concave)
      .number(polygons.non_planar)
      .number(polygons.self_crossing)
      .length(polygons.largest_deviation)
      .number(notes.skipped_primitives)
      .number(notes.welded_vertices)
      .number(notes.unused_objects)
      .number(notes.helper_objects)
      .number(number_of(notes.unit))
      .number(number_of(notes.filename_says))
      .number(number_of(notes.media_type_says));
  const std::size_t remarks = std::min(notes.remarks.size(), api::kMaxRemarks);
  writer.number(remarks);
  for (std::size_t i = 0; i < remarks; ++i) writer.text(notes.remarks[i].substr(0, api::kMaxRemarkBytes));
}

// Accepts printable ASCII only: the sentences are shown to users, and a reader writes nothing else.
bool take_remarks(Reader& reader, std::vector<std::string>& remarks) {
  remarks.resize(reader.number(api::kMaxRemarks));
  for (std::string& remark : remarks) {
    remark = reader.text(api::kMaxRemarkBytes);
    if (!std::ranges::all_of(remark, [](char c) { return c >= ' ' && c <= '~'; })) return false;
  }
  return true;
}

bool take_notes(Reader& reader, api::ReadNotes& notes) {
  notes.gzip = reader.number(1) == 1;
  notes.cloud = reader.number(1) == 1;
  api::PolygonNotes& polygons = notes.polygons;
  polygons.count = reader.number();
  polygons.concave = reader.number();
  polygons.non_planar = reader.number();
  polygons.self_crossing = reader.number();
  polygons.largest_deviation = reader.length();
  notes.skipped_primitives = reader.number();
  notes.welded_vertices = reader.number();
  notes.unused_objects = reader.number();
  notes.helper_objects = reader.number();
  return take(reader, is_unit, notes.unit) && take(reader, is_format, notes.filename_says) &&
         take(reader, is_format, notes.media_type_says) && take_remarks(reader, notes.remarks);
}

std::optional<Reply> take_mesh(Reader& reader) {
  Arrays arrays;
  const std::uint64_t format = reader.number(kMostEnumerator);
  arrays.format = static_cast<api::Format>(format);
  if (!is_format(format) || !take_notes(reader, arrays.notes)) return std::nullopt;
  arrays.vertices = reader.number();
  arrays.triangles = reader.number();
  arrays.group_bytes = reader.number(kMostEncodedGroups);
  if (!reader.complete()) return std::nullopt;
  return arrays;
}

std::optional<Reply> take_error(Reader& reader) {
  Error error;
  const std::uint64_t code = reader.number(kMostEnumerator);
  error.code = static_cast<ErrorCode>(code);
  error.message = reader.text(kMostText);
  error.part = reader.text(kMostText);
  error.where = reader.text(kMostText);
  if (!reader.complete() || !is_error_code(code)) return std::nullopt;
  return error;
}

}  // namespace

std::string encode(const Bounds& bounds) {
  return Writer()
      .number(bounds.memory_bytes)
      .number(bounds.input_bytes)
      .number(bounds.cpu_seconds)
      .number(bounds.filter ? 1 : 0)
      .take();
}

std::string encode(const Trial& trial) {
  Writer writer;
  for (const std::string_view text : {trial.limits, trial.filter, trial.small}) writer.text(text.substr(0, kMostText));
  return writer.take();
}

std::string encode(const Request& request) {
  return Writer()
      .number(request.input_bytes)
      .number(request.limits.max_vertices)
      .number(request.limits.max_triangles)
      .number(request.limits.max_expanded_bytes)
      .text(end_of(request.part))
      .text(end_of(request.filename))
      .text(end_of(request.media_type))
      .take();
}

std::string encode(const Reply& reply) {
  Writer writer;
  if (reply) {
    writer.number(kMesh).number(static_cast<std::uint64_t>(reply->format));
    put(writer, reply->notes);
    return writer.number(reply->vertices).number(reply->triangles).number(reply->group_bytes).take();
  }
  const Error& error = reply.error();
  writer.number(kError).number(static_cast<std::uint64_t>(error.code));
  for (const std::string_view text : {error.message, error.part, error.where}) writer.text(text.substr(0, kMostText));
  return writer.take();
}

// A range as one number: its end in the high half.
std::string encode(const api::Groups& groups) {
  Writer writer;
  writer.number(groups.too_many ? 1 : 0).number(groups.named.size());
  for (const Group& group : groups.named) {
    writer.text(group.name).number(group.ranges.size());
    for (const TriangleRange& range : group.ranges) writer.number(std::uint64_t{range.end} << 32U | range.first);
  }
  return writer.take();
}

std::optional<Bounds> decode_bounds(std::string_view message) {
  Reader reader(message);
  Bounds bounds;
  bounds.memory_bytes = reader.number();
  bounds.input_bytes = reader.number();
  bounds.cpu_seconds = reader.number();
  bounds.filter = reader.number(1) == 1;
  if (!reader.complete()) return std::nullopt;
  return bounds;
}

std::optional<Trial> decode_trial(std::string_view message) {
  Reader reader(message);
  Trial trial;
  trial.limits = reader.text(kMostText);
  trial.filter = reader.text(kMostText);
  trial.small = reader.text(kMostText);
  if (!reader.complete()) return std::nullopt;
  return trial;
}

std::optional<Request> decode_request(std::string_view message) {
  Reader reader(message);
  Request request;
  request.input_bytes = reader.number();
  request.limits.max_vertices = reader.number();
  request.limits.max_triangles = reader.number();
  request.limits.max_expanded_bytes = reader.number();
  request.part = reader.text(kMostHint);
  request.filename = reader.text(kMostHint);
  request.media_type = reader.text(kMostHint);
  if (!reader.complete()) return std::nullopt;
  return request;
}

std::optional<Reply> decode_reply(std::string_view message) {
  Reader reader(message);
  switch (reader.number()) {
    case kMesh:
      return take_mesh(reader);
    case kError:
      return take_error(reader);
    default:
      return std::nullopt;
  }
}

// After its first error a reader returns 0 and "", so the loops end. Memory: a constant, and 8 bytes for each 8 read.
std::optional<api::Groups> decode_groups(std::string_view bytes, std::uint64_t triangles) {
  Reader reader(bytes);
  api::Groups groups;
  groups.too_many = reader.number(1) == 1;
  groups.named.resize(reader.number(api::kMostGroupRanges));
  for (Group& group : groups.named) {
    group.name = reader.text(api::kMostBytesOfGroup);
    group.ranges.resize(reader.number(reader.left() / sizeof(std::uint64_t)));
    for (TriangleRange& range : group.ranges) {
      const std::uint64_t number = reader.number();
      range = {static_cast<std::uint32_t>(number), static_cast<std::uint32_t>(number >> 32U)};
    }
  }
  if (!reader.complete() || !is_valid(groups, triangles)) return std::nullopt;
  return groups;
}

}  // namespace meshgauge::server::sandbox
