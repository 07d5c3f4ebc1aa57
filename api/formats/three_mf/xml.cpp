#include "api/formats/three_mf/xml.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

#include <expat.h>

#ifdef __APPLE__
#include <malloc/malloc.h>
#else
#include <malloc.h>
#endif

namespace meshgauge::api {
namespace {

constexpr std::string_view kXml = "http://www.w3.org/XML/1998/namespace";
constexpr std::string_view kXmlns = "http://www.w3.org/2000/xmlns/";
// Each name is compared with the namespace of its prefix, so a long one would cost its length at every element.
constexpr std::size_t kLongestNamespace = 256;
constexpr std::size_t kMostDeclared = 10'000;

XmlDefect invalid(const std::string& what) { return {ErrorCode::unreadable_mesh, "not valid XML: " + what}; }

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

constexpr int kDeepestElement = 64;
constexpr std::string_view kEncrypted = "%3McF";  // begins an encrypted part of a 3MF, and no XML
// expat rescans a tag from its beginning for every piece of it, so long tags would take quadratic time.
constexpr XML_Index kLongestTag = XML_Index{1} << 20U;
// expat keeps every name that it reads, with a few dozen bytes each.
constexpr std::size_t kMostHeld = std::size_t{64} << 20U;

// Bytes held by the parser of this thread; there is one at a time.
thread_local std::size_t held = 0;

#ifdef __APPLE__
std::size_t usable_bytes(void* block) { return malloc_size(block); }
#else
std::size_t usable_bytes(void* block) { return malloc_usable_size(block); }
#endif

bool may_take(std::size_t bytes) { return held <= kMostHeld && bytes <= kMostHeld - held; }

void* counted_malloc(std::size_t bytes) {
  void* block = may_take(bytes) ? std::malloc(bytes) : nullptr;
  if (block != nullptr) held += usable_bytes(block);
  return block;
}

void counted_free(void* block) {
  if (block != nullptr) held -= usable_bytes(block);
  std::free(block);
}

void* counted_realloc(void* block, std::size_t bytes) {
  const std::size_t before = block == nullptr ? 0 : usable_bytes(block);
  if (bytes > before && !may_take(bytes - before)) return nullptr;
  void* moved = std::realloc(block, bytes);
  if (moved != nullptr) held += usable_bytes(moved) - before;
  return moved;
}

// Returns a different seed each time, so that no document can be crafted whose names all collide. expat itself would
// need a system call.
std::uint64_t unforeseen(const void* address) {
  const auto now = static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  return ((now ^ reinterpret_cast<std::uintptr_t>(address)) * 0x9E3779B97F4A7C15U) | 1U;
}

// expat 2.8 takes a salt of 16 bytes, and 2.9 has these numbers in 64 bits; the names before are deprecated then.
#if XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION < 8
void set_salt(XML_Parser parser, std::uint64_t salt) { XML_SetHashSalt(parser, salt); }
#else
void set_salt(XML_Parser parser, std::uint64_t salt) {
  const std::array<std::uint64_t, 2> bytes{salt, ~salt};
  XML_SetHashSalt16Bytes(parser, reinterpret_cast<const std::uint8_t*>(bytes.data()));
}
#endif
// expat 2.6 puts off a tag that was cut until as much again has come. Here a tag of which the rest has come is wanted
// at once; pieces of 64 KiB and kLongestTag limit how often a cut one is read again.
#if XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION < 6
void defer_nothing(XML_Parser /*parser*/) {}
#else
void defer_nothing(XML_Parser parser) { XML_SetReparseDeferralEnabled(parser, XML_FALSE); }
#endif
#if XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION < 9
std::uint64_t line_of(XML_Parser parser) { return XML_GetCurrentLineNumber(parser); }
std::int64_t byte_of(XML_Parser parser) { return XML_GetCurrentByteIndex(parser); }
#else
std::uint64_t line_of(XML_Parser parser) { return XML_GetCurrentLineNumber64(parser); }
std::int64_t byte_of(XML_Parser parser) { return XML_GetCurrentByteIndex64(parser); }
#endif

// Returns false for an attribute that may declare a namespace or have a prefix. Names are short, and most have neither.
bool is_plain(const char* name) {
  if (name[0] == 'x' && name[1] == 'm') return false;
  while (*name != '\0' && *name != ':') ++name;
  return *name == '\0';
}

// Returns true for the beginning of a document whose ASCII characters are one byte each; expat finds out UTF-16 by the
// same bytes.
bool begins_with_ascii(std::string_view text) {
  text.remove_prefix(static_cast<std::size_t>(after_mark(text) - text.data()));
  return text.size() > 1 && text[0] == '<' && text[1] != '\0';
}

class XmlReader {
 public:
  XmlReader(const Source& source, const std::string& name, XmlHandler& handler);

  std::optional<Error> feed(std::string_view piece);
  std::optional<Error> finish() { return parse({}, true); }

 private:
  struct Free {
    void operator()(XML_Parser parser) const { XML_ParserFree(parser); }
  };

  // No exception may pass through expat, which is C. After XML_StopParser() expat may still report the end of an
  // element.
  template <class Step>
  void step(const Step& step) {
    if (defect_ || no_memory_) return;
    try {
      defect_ = step();
    } catch (const std::exception&) {
      no_memory_ = true;  // the only exception thrown
    }
    if (defect_ || no_memory_) XML_StopParser(parser_.get(), XML_FALSE);
  }

  std::optional<Error> parse(std::string_view piece, bool is_last);
  std::optional<Error> feed_tags(std::string_view& piece);
  std::size_t next_stop(std::string_view tags) const;
  void note_tag() { tag_end_ = byte_of(parser_.get()) + XML_GetCurrentByteCount(parser_.get()); }
  bool is_behind_tag() const { return tag_end_ == fed_; }
  // Bytes of a tag, a comment or the like whose end is not fed yet.
  std::int64_t bytes_held() const {
    const std::int64_t reached = byte_of(parser_.get());
    return reached < 0 ? 0 : fed_ - reached;
  }

  std::optional<XmlDefect> start(const char* name, const char** attributes);
  std::optional<XmlDefect> declare_namespaces(const char** attributes);
  std::optional<XmlDefect> resolve(std::string_view written, bool is_element, XmlName& name);
  // Most text in a model is space between elements, so expat reports text only on request.
  void listen() { XML_SetCharacterDataHandler(parser_.get(), handler_.wants_text() ? on_text : nullptr); }
  Error here(ErrorCode code, const std::string& what) const;
  Error fault() const;

  static void XMLCALL on_start(void* self, const char* name, const char** attributes);
  static void XMLCALL on_end(void* self, const char* name);
  static void XMLCALL on_text(void* self, const char* text, int bytes);
  static void XMLCALL on_document_type(void* self, const char* name, const char* system, const char* public_id,
                                       int has_internal_subset);

  const Source& source_;
  const std::string& name_;
  XmlHandler& handler_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, Free> parser_;
  // Places in the bytes that expat gets. It gets all but those that the handler takes.
  std::int64_t fed_ = 0;
  std::int64_t tag_end_ = -1;  // of the last tag
  std::uint64_t taken_lines_ = 0;
  bool has_ascii_ = false;  // false: in UTF-16
  int depth_ = 0;
  XmlNamespaces namespaces_;
  std::vector<XmlAttribute> prefixed_;  // of the current element
  std::optional<XmlDefect> defect_;
  bool no_memory_ = false;
};

XmlReader::XmlReader(const Source& source, const std::string& name, XmlHandler& handler)
    : source_(source), name_(name), handler_(handler) {
  constexpr XML_Memory_Handling_Suite kMemory{counted_malloc, counted_realloc, counted_free};
  parser_.reset(XML_ParserCreate_MM(nullptr, &kMemory, nullptr));
  if (!parser_) throw std::bad_alloc();
  set_salt(parser_.get(), unforeseen(this));
  defer_nothing(parser_.get());
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), on_start, on_end);
  XML_SetStartDoctypeDeclHandler(parser_.get(), on_document_type);
}

void XmlReader::on_start(void* self, const char* name, const char** attributes) {
  XmlReader& reader = *static_cast<XmlReader*>(self);
  reader.note_tag();
  reader.step([&] { return reader.start(name, attributes); });
}

void XmlReader::on_end(void* self, const char* /*name*/) {
  XmlReader& reader = *static_cast<XmlReader*>(self);
  reader.note_tag();
  reader.step([&]() -> std::optional<XmlDefect> {
    reader.namespaces_.close(reader.depth_--);
    reader.handler_.end();
    reader.listen();
    return std::nullopt;
  });
}

void XmlReader::on_text(void* self, const char* text, int bytes) {
  XmlReader& reader = *static_cast<XmlReader*>(self);
  reader.step([&]() -> std::optional<XmlDefect> {
    reader.handler_.text({text, static_cast<std::size_t>(bytes)});
    return std::nullopt;
  });
}

void XmlReader::on_document_type(void* self, const char* /*name*/, const char* /*system*/, const char* /*public_id*/,
                                 int /*has_internal_subset*/) {
  static_cast<XmlReader*>(self)->step([]() -> std::optional<XmlDefect> {
    return XmlDefect{ErrorCode::unreadable_mesh, "a document type (DTD), which is not allowed here"};
  });
}

std::optional<XmlDefect> XmlReader::start(const char* name, const char** attributes) {
  if (++depth_ > kDeepestElement) return XmlDefect{ErrorCode::unreadable_mesh, "XML nested deeper than 64"};
  if (auto defect = declare_namespaces(attributes)) return defect;
  XmlName element;
  if (auto defect = resolve(name, true, element)) return defect;
  for (XmlAttribute& attribute : prefixed_) {
    if (auto defect = resolve(attribute.name.written, false, attribute.name)) return defect;
  }
  if (auto defect = XmlNamespaces::check_unique(prefixed_)) return defect;
  auto defect = handler_.start(element, XmlAttributes(attributes, prefixed_));
  listen();
  return defect;
}

// Sets prefixed_ to the attributes with a prefix, not resolved yet, since a declaration may follow them.
std::optional<XmlDefect> XmlReader::declare_namespaces(const char** attributes) {
  prefixed_.clear();
  for (const char** pair = attributes; *pair != nullptr; pair += 2) {
    if (is_plain(pair[0])) continue;
    const std::string_view written = pair[0];
    if (const auto prefix = XmlNamespaces::declared_by(written)) {
      if (auto defect = namespaces_.declare(*prefix, pair[1], depth_)) return defect;
      handler_.declare(*prefix, pair[1]);
    } else if (written.find(':') != std::string_view::npos) {
      prefixed_.push_back({{"", "", written}, pair[1]});
    }
  }
  return std::nullopt;
}

std::optional<XmlDefect> XmlReader::resolve(std::string_view written, bool is_element, XmlName& name) {
  if (auto defect = namespaces_.resolve(written, is_element, name)) return defect;
  return name.has_prefix() && name.space.empty() ? handler_.undeclared(name) : std::nullopt;
}

Error XmlReader::here(ErrorCode code, const std::string& what) const {
  const std::string line = ", line " + std::to_string(line_of(parser_.get()) + taken_lines_);
  return at(source_, printable(name_, 100) + line, code, what);
}

Error XmlReader::fault() const {
  const XML_Error code = XML_GetErrorCode(parser_.get());
  if (code == XML_ERROR_NO_MEMORY) {
    return here(ErrorCode::too_large, "the XML has too many different names to be held in 64 MiB");
  }
  const XmlDefect defect = invalid(XML_ErrorString(code));
  return here(defect.code, defect.what);
}

std::optional<Error> XmlReader::feed(std::string_view piece) {
  if (fed_ == 0 && piece.starts_with(kEncrypted)) {
    return at(source_, printable(name_, 100), ErrorCode::unsupported_format,
              "encrypted by the secure content extension, which is not supported; save it without encryption");
  }
  if (fed_ == 0) has_ascii_ = begins_with_ascii(piece);
  if (has_ascii_) {
    if (auto error = feed_tags(piece)) return error;
  }
  if (!piece.empty()) {
    if (auto error = parse(piece, false)) return error;
  }
  if (bytes_held() > kLongestTag) return here(ErrorCode::too_large, "a tag or a comment of more than 1 MiB");
  return std::nullopt;
}

// Gives tags to the handler that takes them and to expat, as far as they alternate, and removes them from `piece`.
std::optional<Error> XmlReader::feed_tags(std::string_view& piece) {
  for (std::size_t left = piece.rfind('>') + 1; left != 0;) {
    if (is_behind_tag() && handler_.takes()) {
      const XmlTaken taken = handler_.take(piece.substr(0, left));
      taken_lines_ += taken.lines;
      piece.remove_prefix(taken.bytes);
      left -= taken.bytes;
    }
    const std::size_t stop = next_stop(piece.substr(0, left));
    if (stop == 0) break;
    if (auto error = parse(piece.substr(0, stop), false)) return error;
    piece.remove_prefix(stop);
    left -= stop;
    if (!is_behind_tag()) break;  // in a comment, for example: each further stop could rescan it
  }
  return std::nullopt;
}

// Returns how many bytes of `tags`, which ends with '>', expat gets before the handler may take others. 0: there are
// none such, or expat holds so much of a tag or a comment that scanning it anew at each stop would take long.
std::size_t XmlReader::next_stop(std::string_view tags) const {
  constexpr std::int64_t kMostRescanned = 4096;
  if (tags.empty() || bytes_held() > kMostRescanned) return 0;
  const std::size_t tag = handler_.takes() ? 0 : handler_.find_taking(tags);
  return tag == std::string_view::npos ? 0 : tags.find('>', tag) + 1;
}

std::optional<Error> XmlReader::parse(std::string_view piece, bool is_last) {
  fed_ += static_cast<std::int64_t>(piece.size());
  const XML_Status status = XML_Parse(parser_.get(), piece.data(), static_cast<int>(piece.size()), is_last ? 1 : 0);
  if (no_memory_) return out_of_memory(source_.part);
  if (defect_) return here(defect_->code, defect_->what);
  return status == XML_STATUS_OK ? std::nullopt : std::optional(fault());
}

}  // namespace

const char* XmlAttributes::find(std::string_view name) const {
  for (const char* const* pair = pairs_; *pair != nullptr; pair += 2) {
    if (*pair == name) return pair[1];
  }
  return nullptr;
}

const char* XmlAttributes::find(std::string_view name_space, std::string_view local) const {
  for (const XmlAttribute& attribute : prefixed_) {
    if (attribute.name.is(name_space, local)) return attribute.value;
  }
  return nullptr;
}

std::optional<XmlDefect> XmlHandler::undeclared(const XmlName& name) {
  return invalid("the prefix of " + in_quotes(name.written) + " is not declared");
}

Result<Done> read_xml(const Source& source, ZipArchive& archive, const std::string& name, XmlHandler& handler) {
  XmlReader reader(source, name, handler);
  auto ok = archive.read(name, [&](std::string_view piece) { return reader.feed(piece); });
  if (!ok) return ok;
  if (auto error = reader.finish()) return std::move(*error);
  return Done{};
}

}  // namespace meshgauge::api
