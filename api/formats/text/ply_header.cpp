#include "api/formats/text/ply_header.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

// More than any exporter writes; bounds the memory for a header.
constexpr std::size_t kMostElements = 100;
constexpr std::size_t kMostProperties = 1000;  // per element

// Starts of format, element, property and end_header: a word that begins like one of them is a misspelt keyword.
constexpr std::string_view kKeywordStarts[] = {"for", "ele", "pro", "end"};

struct TypeName {
  std::string_view name;
  PlyType type;
};
constexpr TypeName kTypeNames[] = {
    {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
    {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
    {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
    {"float64", PlyType::float64}};

std::optional<PlyType> type_named(std::string_view name) {
  const auto* found = std::ranges::find(kTypeNames, name, &TypeName::name);
  if (found == std::end(kTypeNames)) return std::nullopt;
  return found->type;
}

bool has_named(const auto& things, std::string_view name) {
  return std::ranges::any_of(things, [name](const auto& thing) { return thing.name == name; });
}

class HeaderReader {
 public:
  explicit HeaderReader(const Source& source) : source_(source), p_(after_mark(source.text())), end_(source.end()) {}

  Result<PlyHeader> read();

 private:
  bool next_line();
  std::string_view word();
  Result<Done> statement(std::string_view keyword);
  Result<Done> format();
  Result<Done> element();
  Result<Done> property();
  Result<Done> unknown(std::string_view keyword);
  Result<PlyType> type(std::string_view name) const;
  Error fail(const std::string& what) const {
    return at_line(source_, line_, ErrorCode::unreadable_mesh, "PLY header: " + what);
  }

  const Source& source_;
  const char* p_;  // the start of the next line
  const char* end_;
  const char* line_ = nullptr;  // the start of this line
  const char* word_ = nullptr;  // the rest of this line
  const char* line_end_ = nullptr;
  bool format_seen_ = false;
  PlyHeader header_;
};

// Moves to the next line. false: the file ends, or the line has no end, since a header is never the end of a file.
bool HeaderReader::next_line() {
  line_ = word_ = p_;
  line_end_ = skip_line(p_, end_);
  if (line_end_ == end_) return false;
  p_ = line_end_ + 1;
  // If lines end with \r alone, a \n after the header belongs to the data.
  const std::string_view text(after_mark(source_.text()), end_);
  const bool cr_only = text.starts_with("ply\r") && !text.starts_with("ply\r\n");
  if (*line_end_ == '\r' && p_ != end_ && *p_ == '\n' && !cr_only) ++p_;
  return true;
}

std::string_view HeaderReader::word() {
  word_ = skip_spaces(word_, line_end_);
  const std::string_view found = word_at(word_, line_end_);
  word_ += found.size();
  return found;
}

Result<PlyType> HeaderReader::type(std::string_view name) const {
  if (const auto found = type_named(name)) return *found;
  return fail(in_quotes(name) + " is not a PLY type");
}

Result<Done> HeaderReader::format() {
  const std::string_view encoding = word();
  const std::string_view version = word();
  if (encoding == "ascii") {
    header_.encoding = PlyEncoding::ascii;
  } else if (encoding == "binary_little_endian") {
    header_.encoding = PlyEncoding::little_endian;
  } else if (encoding == "binary_big_endian") {
    header_.encoding = PlyEncoding::big_endian;
  } else {
    return fail("format " + in_quotes(encoding) + " is not known");
  }
  if (version != "1.0") return fail("version " + in_quotes(version) + " is not supported, only 1.0");
  format_seen_ = true;
  return Done{};
}

Result<Done> HeaderReader::element() {
  PlyElement element;
  element.name = word();
  const std::string_view count = word();
  std::int64_t value = 0;
  if (parse_integer(count.data(), count.data() + count.size(), value) != count.data() + count.size() || value < 0) {
    return fail(in_quotes(count) + " is not a count of elements");
  }
  if (has_named(header_.elements, element.name)) return fail("a second element " + in_quotes(element.name));
  if (header_.elements.size() == kMostElements) return fail("more than 100 elements");
  element.count = static_cast<std::uint64_t>(value);
  header_.elements.push_back(std::move(element));
  return Done{};
}

Result<Done> HeaderReader::property() {
  if (header_.elements.empty()) return fail("a property before any element");
  PlyProperty property;
  std::string_view type_name = word();
  if (type_name == "list") {
    property.is_list = true;
    const auto count_type = type(word());
    if (!count_type) return count_type.error();
    if (!is_integer(*count_type)) return fail("the length of a list must be of an integer type");
    property.count_type = *count_type;
    type_name = word();
  }
  const auto value_type = type(type_name);
  if (!value_type) return value_type.error();
  property.type = *value_type;
  property.name = word();
  if (property.name.empty()) return fail("a property without a name");
  std::vector<PlyProperty>& properties = header_.elements.back().properties;
  if (has_named(properties, property.name)) return fail("a second property " + in_quotes(property.name));
  if (properties.size() == kMostProperties) return fail("more than 1000 properties of one element");
  properties.push_back(std::move(property));
  return Done{};
}

Result<Done> HeaderReader::statement(std::string_view keyword) {
  if (keyword == "comment" || keyword == "obj_info" || keyword.empty()) return Done{};
  if (keyword == "format") return format();
  if (keyword == "element") return element();
  if (keyword == "property") return property();
  return unknown(keyword);
}

// Ignores a line of an unknown word: some programs write a name or a date without "comment". Refuses a line that looks
// like an element or a property: without it, all later values would be misread.
Result<Done> HeaderReader::unknown(std::string_view keyword) {
  const std::string_view second = word(), third = word(), fourth = word();
  std::int64_t ignored = 0;
  const char* const third_end = third.data() + third.size();
  const bool counts = fourth.empty() && parse_integer(third.data(), third_end, ignored) == third_end;
  const bool starts_alike = std::ranges::any_of(
      kKeywordStarts, [&](std::string_view start) { return same_word(keyword.substr(0, start.size()), start); });
  if (!is_letter(keyword.front()) || starts_alike || counts || second == "list" || type_named(second)) {
    return fail(in_quotes(keyword) + " is not a header keyword");
  }
  if (++header_.unknown_lines == 1) header_.first_unknown = in_quotes(keyword);
  return Done{};
}

Result<PlyHeader> HeaderReader::read() {
  next_line();  // "ply"
  while (next_line()) {
    const std::string_view keyword = word();
    if (keyword == "end_header") {
      if (!format_seen_) return fail("no format before end_header");
      header_.body = p_;
      return std::move(header_);
    }
    if (auto ok = statement(keyword); !ok) return std::move(ok).error();
  }
  return fail("the file ends before end_header");
}

const PlyElement* find_element(const PlyHeader& header, std::string_view name) {
  const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
  return found == header.elements.end() ? nullptr : &*found;
}

const PlyProperty* find_property(const PlyElement& element, std::string_view name) {
  const auto found = std::ranges::find(element.properties, name, &PlyProperty::name);
  return found == element.properties.end() ? nullptr : &*found;
}

Error header_error(const Source& source, ErrorCode code, const std::string& what) {
  return at(source, "the PLY header", code, what);
}

Result<Done> check_coordinates(const Source& source, const PlyElement& vertex) {
  for (const std::string name : {"x", "y", "z"}) {
    const PlyProperty* property = find_property(vertex, name);
    if (property == nullptr) {
      return header_error(source, ErrorCode::unreadable_mesh, "element 'vertex' has no property '" + name + "'");
    }
    if (property->is_list) {
      return header_error(source, ErrorCode::unreadable_mesh, "property '" + name + "' is a list");
    }
  }
  return Done{};
}

// Returns the list of corners of an element; nullptr: no such element.
Result<const PlyProperty*> find_corners(const Source& source, const PlyElement* element, const std::string& name) {
  if (element == nullptr) return nullptr;
  const PlyProperty* corners = find_property(*element, "vertex_indices");
  if (corners == nullptr) corners = find_property(*element, "vertex_index");
  if (corners == nullptr || !corners->is_list) {
    return header_error(source, ErrorCode::unreadable_mesh, "element '" + name + "' has no list 'vertex_indices'");
  }
  if (!is_integer(corners->type)) {
    return header_error(source, ErrorCode::unreadable_mesh, "'" + corners->name + "' is not of an integer type");
  }
  return corners;
}

bool is_one_of(std::string_view name, std::span<const std::string_view> names) {
  return std::ranges::find(names, name) != names.end();
}

bool has_one_of(std::string_view name, std::span<const std::string_view> words) {
  return std::ranges::any_of(words,
                             [name](std::string_view word) { return name.find(word) != std::string_view::npos; });
}

bool are_lines(const PlyElement& element) {
  constexpr std::string_view kNames[] = {"edge", "edges", "line", "lines", "polyline", "polylines"};
  return is_one_of(lower_case(element.name), kNames);
}

bool is_attribute(const PlyProperty& property) {
  constexpr std::string_view kWords[] = {"tex", "uv", "normal", "color", "colour", "material"};
  std::string name = lower_case(property.name.substr(0, 64));                           // names have any length
  while (name.find("vertex") != std::string::npos) name.erase(name.find("vertex"), 6);  // has "tex"
  return has_one_of(name, kWords);
}

// Whether a property is one vertex of several: "v1", "vertex2".
bool is_corner(const PlyProperty& property) {
  if (property.is_list || !is_integer(property.type) || property.name.empty() || !is_digit(property.name.back())) {
    return false;
  }
  const std::size_t letters = property.name.find_first_of("0123456789");
  return is_one_of(lower_case(property.name.substr(0, letters)),
                   std::array<std::string_view, 3>{"v", "vertex", "vertex_"});
}

// Whether a property may be one vertex of several under any name. A byte is a colour.
bool may_be_corner(const PlyProperty& property) {
  return is_corner(property) || (!property.is_list && is_integer(property.type) && size_of(property.type) > 1);
}

// Whether an element that is not read may be surface: because of a list that may hold corners or points, or of three
// properties that may be corners.
bool may_be_surface(const PlyElement& element) {
  constexpr std::string_view kNeverSurface[] = {"camera", "cameras", "material", "materials", "texture", "textures"};
  const std::string name = lower_case(element.name);
  if (element.properties.empty() || is_one_of(name, kNeverSurface) || are_lines(element)) return false;
  const auto holds_points = [](const PlyProperty& property) { return property.is_list && !is_attribute(property); };
  return std::ranges::any_of(element.properties, holds_points) ||
         std::ranges::count_if(element.properties, may_be_corner) >= 3;
}

}  // namespace

std::size_t PlyElement::least_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    bytes += size_of(property.is_list ? property.count_type : property.type);
  }
  return bytes;
}

bool is_ply(std::string_view text) { return word_at(after_mark(text), text.data() + text.size()) == "ply"; }

Result<PlyHeader> read_ply_header(const Source& source) {
  if (is_ply(source.text())) return HeaderReader(source).read();
  const std::string_view line(source.begin(), skip_line(source.begin(), source.end()));
  return at_line(source, source.begin(), ErrorCode::unreadable_mesh,
                 "PLY header: line 1 is not 'ply' but " + in_quotes(line));
}

bool may_hold_corners(const PlyProperty& property) {
  return property.is_list && is_integer(property.type) && !is_attribute(property);
}

Result<PlyLayout> find_layout(const Source& source, const PlyHeader& header) {
  PlyLayout layout;
  layout.vertex = find_element(header, "vertex");
  if (layout.vertex == nullptr) return header_error(source, ErrorCode::empty_mesh, "no element 'vertex'");
  if (auto ok = check_coordinates(source, *layout.vertex); !ok) return std::move(ok).error();
  const PlyElement *face = find_element(header, "face"), *strip = find_element(header, "tristrips");
  const auto faces = find_corners(source, face, "face");
  if (!faces) return faces.error();
  const auto strips = find_corners(source, strip, "tristrips");
  if (!strips) return strips.error();
  layout.face_corners = *faces;
  layout.strip_corners = *strips;
  layout.only_points = true;
  for (const PlyElement& element : header.elements) {
    if (&element == layout.vertex || &element == face || &element == strip) continue;
    if (element.count == 0 && std::ranges::none_of(element.properties, &PlyProperty::is_list)) continue;
    const bool lines = are_lines(element), surface = may_be_surface(element);
    layout.only_points = layout.only_points && !lines && !surface;
    if (lines && !element.properties.empty()) layout.lines += element.count;
    if (surface && element.count > 0) layout.unread.add("elements " + in_quotes(element.name), element.count);
  }
  if (face != nullptr || strip != nullptr || layout.only_points || !layout.unread.empty()) return layout;
  return header_error(source, ErrorCode::empty_mesh, "neither an element 'face' nor 'tristrips', so no triangles");
}

}  // namespace meshgauge::api
