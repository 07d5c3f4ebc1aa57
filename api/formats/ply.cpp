#include "api/formats/ply.h"

#include <utility>

#include "api/formats/ply_header.h"
#include "api/formats/ply_layout.h"
#include "api/formats/ply_values.h"
#include "api/formats/polygons.h"
#include "api/formats/room.h"

namespace meshgauge::api {
namespace {

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

template <class Values>
bool BodyReader<Values>::vertices(const PlyElement& element) {
  // The coordinate of each property: 0 to 2; 3: none.
  std::vector<int> axes;
  for (const PlyProperty& property : element.properties) {
    const std::size_t axis = property.name.size() == 1 ? std::string_view("xyz").find(property.name) : 3;
    axes.push_back(axis < 3 ? static_cast<int>(axis) : 3);
  }
  reserve_room(out_.mesh.positions, element.count);
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

template <class Values>
bool BodyReader<Values>::records(const PlyElement& element) {
  const bool has_faces = element.name == "face" || element.name == "tristrips";
  std::vector<std::size_t> unread(element.properties.size());
  for (std::uint64_t i = 0; i < element.count; ++i) {
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
  if (const std::size_t lines = values_.longer_records(); lines != 0) {
    out_.notes.remarks.push_back("lines with more values than the header announces, the others ignored: " +
                                 std::to_string(lines));
  }
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
