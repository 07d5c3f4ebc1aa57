#include "api/formats/xml_names.h"

#include <algorithm>

#include "api/formats/source.h"

namespace meshgauge::api {
namespace {

constexpr std::string_view kXml = "http://www.w3.org/XML/1998/namespace";
constexpr std::string_view kXmlns = "http://www.w3.org/2000/xmlns/";
// Each name is compared with the namespace of its prefix, so a long one would cost its length at every element.
constexpr std::size_t kLongestNamespace = 256;
constexpr std::size_t kMostDeclared = 10'000;

XmlDefect invalid(const std::string& what) { return {ErrorCode::unreadable_mesh, "not valid XML: " + what}; }

}  // namespace

std::optional<std::string_view> XmlNamespaces::declared_by(std::string_view attribute) {
  constexpr std::string_view kWord = "xmlns";
  if (!attribute.starts_with(kWord)) return std::nullopt;
  attribute.remove_prefix(kWord.size());
  if (attribute.empty()) return attribute;
  const bool is_prefix = attribute.size() > 1 && attribute.rfind(':') == 0;
  return is_prefix ? std::optional(attribute.substr(1)) : std::nullopt;
}

std::optional<XmlDefect> XmlNamespaces::declare(std::string_view prefix, std::string_view name_space, int depth) {
  if (name_space.size() > kLongestNamespace) {
    return XmlDefect{ErrorCode::too_large, "the namespace " + in_quotes(name_space) + " has more than 256 bytes"};
  }
  if (open_.size() == kMostDeclared) return XmlDefect{ErrorCode::too_large, "more than 10000 namespaces at a time"};
  if (prefix == "xml" && name_space == kXml) return std::nullopt;
  if (prefix == "xml" || prefix == "xmlns" || name_space == kXml || name_space == kXmlns) {
    return invalid("a reserved prefix or namespace is declared, " + in_quotes(prefix));
  }
  if (prefix.empty()) {
    defaults_.emplace_back(name_space);
    open_.emplace_back(depth, prefixes_.end());
    return std::nullopt;
  }
  if (name_space.empty()) return invalid("the prefix " + in_quotes(prefix) + " is declared without a namespace");
  auto known = prefixes_.find(prefix);
  if (known == prefixes_.end()) known = prefixes_.emplace(prefix, Map::mapped_type()).first;
  known->second.emplace_back(name_space);
  open_.emplace_back(depth, known);
  return std::nullopt;
}

void XmlNamespaces::close(int depth) {
  for (; !open_.empty() && open_.back().first == depth; open_.pop_back()) {
    const Map::iterator prefix = open_.back().second;
    std::vector<std::string>& spaces = prefix == prefixes_.end() ? defaults_ : prefix->second;
    spaces.pop_back();
    if (spaces.empty()) prefixes_.erase(prefix);
  }
}

std::optional<XmlDefect> XmlNamespaces::resolve(std::string_view written, bool is_element, XmlName& name) const {
  const std::size_t colon = written.find(':');
  if (colon == std::string_view::npos) {
    name = {is_element ? std::string_view(defaults_.back()) : std::string_view(), written, written};
    return std::nullopt;
  }
  const std::string_view prefix = written.substr(0, colon);
  const std::string_view local = written.substr(colon + 1);
  if (prefix.empty() || local.empty() || local.find(':') != std::string_view::npos) {
    return invalid("the name " + in_quotes(written) + " has a colon out of place");
  }
  const auto known = prefixes_.find(prefix);
  const std::string_view reserved = prefix == "xml" ? kXml : std::string_view();
  name = {known == prefixes_.end() ? reserved : std::string_view(known->second.back()), local, written};
  return std::nullopt;
}

std::optional<XmlDefect> XmlNamespaces::check_unique(const std::vector<XmlAttribute>& attributes) {
  if (attributes.size() < 2) return std::nullopt;
  std::vector<std::pair<std::string_view, std::string_view>> names;
  for (const XmlAttribute& one : attributes) {
    if (!one.name.space.empty()) names.emplace_back(one.name.local, one.name.space);
  }
  std::ranges::sort(names);
  const auto twice = std::ranges::adjacent_find(names);
  if (twice == names.end()) return std::nullopt;
  return invalid("duplicate attribute " + in_quotes(twice->first));
}

}  // namespace meshgauge::api
