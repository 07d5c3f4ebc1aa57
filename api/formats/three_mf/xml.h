// Reads XML from a zip archive element by element, by expat. Refuses a document type, and with it every entity except
// the standard's five; opens nothing outside. Limits on nesting, the length of a tag, namespaces and the memory for
// names bound time and memory by the document's size. A handler may take frequent elements before expat gets them.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file/source.h"
#include "api/formats/file/zip.h"
#include "engine/result.h"

namespace meshgauge::api {

struct XmlDefect {
  ErrorCode code = ErrorCode::unreadable_mesh;
  std::string what;
};

struct XmlName {
  std::string_view space;    // empty: without a namespace, or with a prefix that is not declared
  std::string_view local;    // "path" of "p:path"
  std::string_view written;  // "p:path", as the document has it

  bool is(std::string_view name_space, std::string_view name) const { return local == name && space == name_space; }
  bool has_prefix() const { return written.size() != local.size(); }
  std::string_view prefix() const { return written.substr(0, written.size() - local.size() - (has_prefix() ? 1 : 0)); }
};

struct XmlAttribute {
  XmlName name;
  const char* value = nullptr;
};

class XmlAttributes {
 public:
  // `pairs`: name, value, name, value, ..., nullptr, as from expat. `prefixed`: those with a prefix, resolved.
  XmlAttributes(const char* const* pairs, const std::vector<XmlAttribute>& prefixed)
      : pairs_(pairs), prefixed_(prefixed) {}

  const char* const* pairs() const { return pairs_; }
  // Without the declarations of namespaces.
  const std::vector<XmlAttribute>& prefixed() const { return prefixed_; }

  // Return the value of an attribute without a prefix, and of one of a namespace. nullptr: there is none.
  const char* find(std::string_view name) const;
  const char* find(std::string_view name_space, std::string_view local) const;

 private:
  const char* const* pairs_;
  const std::vector<XmlAttribute>& prefixed_;
};

// What XmlHandler::take() took.
struct XmlTaken {
  std::size_t bytes = 0;
  std::size_t lines = 0;  // line ends in them
};

class XmlHandler {
 public:
  XmlHandler() = default;
  XmlHandler(const XmlHandler&) = delete;
  XmlHandler& operator=(const XmlHandler&) = delete;
  virtual ~XmlHandler() = default;

  // Called with a prefix and its namespace before start() of the element that declares it.
  virtual void declare(std::string_view /*prefix*/, std::string_view /*name_space*/) {}
  // Called at the start of an element. A defect ends the reading.
  virtual std::optional<XmlDefect> start(const XmlName& name, const XmlAttributes& attributes) = 0;
  // Called before start() for an element or an attribute whose prefix is not declared. Returns a defect by default.
  virtual std::optional<XmlDefect> undeclared(const XmlName& name);
  virtual void end() {}
  // Returns true when text() is to be called with the text that follows, in any number of pieces. Called at each start
  // and end of an element.
  virtual bool wants_text() const { return false; }
  virtual void text(std::string_view /*piece*/) {}

  // A handler may read the most frequent elements from their bytes, faster than by start() and end().
  // Returns the place of the first tag in `text` behind which takes() may become true; npos: none. A wrong place costs
  // time only.
  virtual std::size_t find_taking(std::string_view /*text*/) const { return std::string_view::npos; }
  // Returns true where take() may be called: behind a tag, without a need for text().
  virtual bool takes() const { return false; }
  // Called with bytes of the document that follow a tag, end with '>' and are ASCII where they look like it. Reads
  // elements at their beginning just as start() and end() would, and stops before the first that is cut off or may not
  // be valid XML; start() gets that one.
  virtual XmlTaken take(std::string_view /*text*/) { return {}; }
};

// Reads the entry `name` of the archive to its end. Errors name the entry and the line.
Result<Done> read_xml(const Source& source, ZipArchive& archive, const std::string& name, XmlHandler& handler);

}  // namespace meshgauge::api
