#include "api/formats/ply.h"

#include <algorithm>
#include <utility>

#include "api/formats/fan.h"
#include "api/formats/ply_header.h"
#include "api/formats/ply_values.h"
#include "api/formats/room.h"

namespace meshgauge::api {
namespace {

const PlyElement* find_element(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

const PlyProperty* find_property(const PlyElement& element, std::string_view name) {
  const auto found = std::ranges::find(element.properties, name, &PlyProperty::name);
  return found == element.properties.end() ? nullptr : &*found;
}

const PlyProperty* corners_property(const PlyElement& face) {
  const PlyProperty* found = find_property(face, "vertex_indices");
  return found != nullptr ? found : find_property(face, "vertex_index");
}

Error header_error(const Source& source, ErrorCode code, const std::string& what) {
  return at(source, "the PLY header", code, what);
}

Result<Done> check_vertex_element(const Source& source, const PlyElement* vertex) {
  if (vertex == nullptr) return header_error(source, ErrorCode::empty_mesh, "no element 'vertex'");
  for (const std::string name : {"x", "y", "z"}) {
    const PlyProperty* property = find_property(*vertex, name);
    if (property == nullptr) {
      return header_error(source, ErrorCode::unreadable_mesh, "element 'vertex' has no property '" + name + "'");
    }
    if (property->is_list) {
      return header_error(source, ErrorCode::unreadable_mesh, "property '" + name + "' is a list");
    }
  }
  return Done{};
}

Result<Done> check_face_element(const Source& source, const PlyElement& face) {
  const PlyProperty* corners = corners_property(face);
  if (corners == nullptr || !corners->is_list) {
    return header_error(source, ErrorCode::unreadable_mesh, "element 'face' has no list 'vertex_indices'");
  }
  if (!is_integer(corners->type)) {
    return header_error(source, ErrorCode::unreadable_mesh, "'" + corners->name + "' is not of an integer type");
  }
  return Done{};
}

Result<Done> check_elements(const Source& source, const PlyHeader& header) {
  if (auto ok = check_vertex_element(source, find_element(header, "vertex")); !ok) return ok;
  if (const PlyElement* face = find_element(header, "face")) return check_face_element(source, *face);
  if (find_element(header, "tristrips") != nullptr) {
    return header_error(source, ErrorCode::unsupported_format, "triangle strips in PLY are not supported");
  }
  return header_error(source, ErrorCode::empty_mesh, "no element 'face', so no triangles");
}

template <class Values>
class BodyReader {
 public:
  BodyReader(const Source& source, const PlyHeader& header)
      : source_(source), header_(header), values_(source, header.body), fan_(out_.mesh.triangles) {
    out_.format = Format::ply;
    vertex_count_ = find_element(header, "vertex")->count;
  }

  Result<ReadMesh> read();

 private:
  bool element(const PlyElement& element);
  bool vertices(const PlyElement& element);
  bool faces(const PlyElement& element);
  bool others(const PlyElement& element);
  bool face_corners(const PlyProperty& property);
  bool skip(const PlyProperty& property);
  bool list_length(const PlyProperty& property, std::int64_t& length);

  const Source& source_;
  const PlyHeader& header_;
  Values values_;
  std::uint64_t vertex_count_ = 0;
  ReadMesh out_;
  Fan fan_;
};

template <class Values>
bool BodyReader<Values>::list_length(const PlyProperty& property, std::int64_t& length) {
  if (!values_.integer(property.count_type, length)) return false;
  if (length >= 0 && length <= std::int64_t{0xFFFFFFFF}) return true;
  return values_.fail(ErrorCode::unreadable_mesh, std::to_string(length) + " is not a length of a list");
}

template <class Values>
bool BodyReader<Values>::skip(const PlyProperty& property) {
  if (!property.is_list) return values_.skip(property.type, 1);
  std::int64_t length = 0;
  return list_length(property, length) && values_.skip(property.type, static_cast<std::uint64_t>(length));
}

template <class Values>
bool BodyReader<Values>::vertices(const PlyElement& element) {
  // Which coordinate each property is; 3 for none.
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
bool BodyReader<Values>::face_corners(const PlyProperty& property) {
  std::int64_t length = 0;
  if (!list_length(property, length)) return false;
  // Bytes that are out of step show as empty faces first: a count of vertices that is too high, for one.
  if (length == 0) return values_.fail(ErrorCode::unreadable_mesh, "a face without corners");
  fan_.begin();
  for (std::int64_t corner = 0; corner < length; ++corner) {
    std::int64_t index = 0;
    if (!values_.integer(property.type, index)) return false;
    if (index < 0 || static_cast<std::uint64_t>(index) >= vertex_count_) {
      return values_.fail(ErrorCode::index_out_of_range, "index " + std::to_string(index) + ", but there are " +
                                                             std::to_string(vertex_count_) + " vertices");
    }
    fan_.add(static_cast<std::uint32_t>(index));
  }
  out_.notes.skipped_primitives += length < 3;
  out_.notes.polygons += length > 3;
  return true;
}

template <class Values>
bool BodyReader<Values>::faces(const PlyElement& element) {
  const PlyProperty* corners = corners_property(element);
  reserve_room(out_.mesh.triangles, element.count);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!(&property == corners ? face_corners(property) : skip(property))) return false;
    }
    if (!values_.end_record()) return false;
    if (out_.mesh.triangles.size() > source_.limits.max_triangles) {
      return values_.fail(ErrorCode::too_large,
                          "more triangles than the limit of " + std::to_string(source_.limits.max_triangles));
    }
  }
  return true;
}

template <class Values>
bool BodyReader<Values>::others(const PlyElement& element) {
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      if (!skip(property)) return false;
    }
    if (!values_.end_record()) return false;
  }
  return true;
}

template <class Values>
bool BodyReader<Values>::element(const PlyElement& element) {
  if (element.properties.empty()) return true;  // records of no bytes, however many
  if (element.count > values_.most_records(element)) {
    return values_.fail(ErrorCode::unreadable_mesh, "truncated: " + std::to_string(element.count) +
                                                        " records of element " + in_quotes(element.name) +
                                                        " do not fit into what remains");
  }
  if (element.name == "vertex") return vertices(element);
  return element.name == "face" ? faces(element) : others(element);
}

template <class Values>
Result<ReadMesh> BodyReader<Values>::read() {
  if (vertex_count_ > vertex_limit(source_)) return too_many(source_, "vertices", vertex_limit(source_));
  for (const PlyElement& next : header_.elements) {
    if (!element(next)) return values_.error();
  }
  if (!values_.end_body()) return values_.error();
  return std::move(out_);
}

}  // namespace

Result<ReadMesh> read_ply(const Source& source) {
  const auto header = read_ply_header(source);
  if (!header) return header.error();
  if (auto ok = check_elements(source, *header); !ok) return std::move(ok).error();
  switch (header->encoding) {
    case PlyEncoding::ascii:
      return BodyReader<PlyText>(source, *header).read();
    case PlyEncoding::little_endian:
      return BodyReader<PlyBytes<std::endian::little>>(source, *header).read();
    case PlyEncoding::big_endian:
      break;
  }
  return BodyReader<PlyBytes<std::endian::big>>(source, *header).read();
}

}  // namespace meshgauge::api
