// Names of elements and attributes in XML: prefixes and the namespaces that they stand for.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

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

// The namespaces declared by the elements that are open. Not expat's, which ends at a prefix that is not declared.
class XmlNamespaces {
 public:
  // Returns the prefix that an attribute declares ("" for "xmlns"); nullopt: it declares none, as "xmlns:" and
  // "xmlns:a:b", whose colons resolve() refuses.
  static std::optional<std::string_view> declared_by(std::string_view attribute);

  // Declares a prefix, "" for the default namespace, for the element at `depth` and those inside. Refuses what XML
  // does not allow, namespaces of more than 256 bytes and more than 10,000 declarations at a time.
  std::optional<XmlDefect> declare(std::string_view prefix, std::string_view name_space, int depth);

  // Ends the declarations of the element at `depth`.
  void close(int depth);

  // Sets the name of an element or an attribute; only elements without a prefix take the default namespace. The name
  // borrows from `written` and from this, until the next declaration or close(). Refuses a colon out of place.
  std::optional<XmlDefect> resolve(std::string_view written, bool is_element, XmlName& name) const;

  // Refuses two attributes of one name, which differ only in their prefixes.
  static std::optional<XmlDefect> check_unique(const std::vector<XmlAttribute>& attributes);

 private:
  using Map =
      std::map<std::string, std::vector<std::string>, std::less<>>;  // prefix -> namespaces, the last one counts

  std::vector<std::string> defaults_{""};
  Map prefixes_;
  std::vector<std::pair<int, Map::iterator>> open_;  // depth and prefix of each declaration; end(): the default
};

}  // namespace meshgauge::api
