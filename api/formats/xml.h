// Reads XML from a zip archive element by element, by expat. Refuses a document type, and with it every entity except
// the standard's five; opens nothing outside. Limits on nesting, the length of a tag and the memory for names bound
// time and memory by the document's size.
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
  // `pairs`: name, value, name, value, ..., nullptr, as from expat.
  explicit XmlAttributes(const char* const* pairs) : pairs_(pairs) {}

  const char* const* pairs() const { return pairs_; }
  const char* find(std::string_view name) const;  // nullptr: there is none

 private:
  const char* const* pairs_;
};

// Separator in names of elements and of prefixed attributes: namespace, separator, local name. A name without namespace
// is the local name alone. No namespace may contain it.
inline constexpr char kXmlSeparator = '\n';

class XmlHandler {
 public:
  XmlHandler() = default;
  XmlHandler(const XmlHandler&) = delete;
  XmlHandler& operator=(const XmlHandler&) = delete;
  virtual ~XmlHandler() = default;

  // Called with a prefix and its namespace before start() of the element that declares it.
  virtual void declare(std::string_view /*prefix*/, std::string_view /*name_space*/) {}
  // Called at the start of an element. A defect ends the reading.
  virtual std::optional<XmlDefect> start(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void end() {}
  // Returns true when text() is to be called with the text that follows, in any number of pieces. Called at each start
  // and end of an element.
  virtual bool wants_text() const { return false; }
  virtual void text(std::string_view /*piece*/) {}
};

// Reads the entry `name` of the archive to its end. Errors name the entry and the line.
Result<Done> read_xml(const Source& source, ZipArchive& archive, const std::string& name, XmlHandler& handler);

}  // namespace meshgauge::api
