// XML from a zip archive, element by element, by expat. What a document may do to its reader beyond naming elements is
// refused: a document type, and with it every entity but the standard's five, and nothing outside is opened. Time and
// memory are bounded by the document's size: nesting, the length of a tag, and what is held of names.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "api/formats/source.h"
#include "api/formats/zip.h"

namespace meshgauge::api {

struct XmlDefect {
  ErrorCode code = ErrorCode::unreadable_mesh;
  std::string what;
};

class XmlAttributes {
 public:
  // Name, value, name, value, ..., nullptr: as expat has them.
  explicit XmlAttributes(const char* const* pairs) : pairs_(pairs) {}

  const char* const* pairs() const { return pairs_; }
  const char* find(std::string_view name) const;  // nullptr: there is none

 private:
  const char* const* pairs_;
};

// Names of elements and of attributes with a prefix are their namespace, this character and their local name; without
// a namespace they are the local name alone. No namespace may hold it.
inline constexpr char kXmlSeparator = '\n';

class XmlHandler {
 public:
  XmlHandler() = default;
  XmlHandler(const XmlHandler&) = delete;
  XmlHandler& operator=(const XmlHandler&) = delete;
  virtual ~XmlHandler() = default;

  // A prefix and what it stands for, told before the element that declares it.
  virtual void declare(std::string_view /*prefix*/, std::string_view /*name_space*/) {}
  // A defect ends the reading.
  virtual std::optional<XmlDefect> start(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void end() {}
  // Whether the text that follows is of use, asked at each start and end; it comes in any number of pieces.
  virtual bool wants_text() const { return false; }
  virtual void text(std::string_view /*piece*/) {}
};

// Reads the entry `name` of the archive to its end. An Error names the entry and the line.
Result<Done> read_xml(const Source& source, ZipArchive& archive, const std::string& name, XmlHandler& handler);

}  // namespace meshgauge::api
