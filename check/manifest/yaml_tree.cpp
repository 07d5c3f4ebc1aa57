#include "check/manifest/yaml_tree.h"

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/exceptions.h>
#include <yaml-cpp/mark.h>
#include <yaml-cpp/parser.h>

#include "api/base/json_filter.h"
#include "api/base/utf8.h"

namespace meshgauge::check {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kNoAlias =
    "'*' begins an alias in YAML, and aliases are not taken: put a glob in quotes, and what gates share under "
    "'defaults'";

// Ends the parsing: further mistakes would be consequences of this one.
struct Stop {
  Place place;
  std::string message;
};

// Converts yaml-cpp's marks, which are 0-based and count bytes.
class Places {
 public:
  explicit Places(std::string_view text) : lines_{0}, characters_{0} {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\n') lines_.push_back(i + 1);
      characters_.push_back(characters_.back() + (is_within_character(text[i]) ? 0 : 1));
    }
  }
  Place operator()(const YAML::Mark& mark) const {
    if (mark.line < 0 || mark.column < 0) return {};
    const auto line = static_cast<std::size_t>(mark.line);
    const std::size_t start = line < lines_.size() ? lines_[line] : characters_.size() - 1;
    return {mark.line + 1, column(start, start + static_cast<std::size_t>(mark.column))};
  }
  Place at(std::size_t byte) const {
    const auto next = std::upper_bound(lines_.begin(), lines_.end(), byte);
    return {static_cast<int>(next - lines_.begin()), column(*(next - 1), byte)};
  }

 private:
  int column(std::size_t start, std::size_t byte) const {
    return characters_[std::min(byte, characters_.size() - 1)] - characters_[start] + 1;
  }

  std::vector<std::size_t> lines_;  // byte where each line begins
  std::vector<int> characters_;     // that begin before each byte: a line may hold all of a manifest
};

class Builder : public YAML::EventHandler {
 public:
  Builder(const Places& places, Mistakes& mistakes) : places_(places), mistakes_(mistakes) {}

  YamlNode root;

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (documents_++ == 0) return;
    throw Stop{places_(mark),
               "one document ends before this line and another begins: indent alike what belongs together, and leave "
               "out '---'"};
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& mark, YAML::anchor_t) override { attach(YamlNode{}, places_(mark)); }
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t) override { throw Stop{places_(mark), std::string(kNoAlias)}; }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, const std::string& value) override {
    refuse_tag(mark, tag);
    YamlNode node;
    node.kind = tag == "!" ? YamlNode::Kind::quoted : YamlNode::Kind::word;
    node.text = value;
    attach(std::move(node), places_(mark));
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {
    open(mark, tag, YamlNode::Kind::list);
  }
  void OnSequenceEnd() override { close(); }
  void OnMapStart(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t, YAML::EmitterStyle::value) override {
    open(mark, tag, YamlNode::Kind::map);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    YamlNode node;
    std::map<std::string, Place> seen;  // keys of the map
    bool awaits_value = false;
  };

  void refuse_tag(const YAML::Mark& mark, const std::string& tag) const {
    if (tag.empty() || tag == "?" || tag == "!") return;
    throw Stop{places_(mark), "tags are not taken: leave out what begins with '!'"};
  }

  void open(const YAML::Mark& mark, const std::string& tag, YamlNode::Kind kind) {
    refuse_tag(mark, tag);
    if (awaits_key())
      throw Stop{places_(mark), "a key must be a text; if none is meant here, a '{' or '[' is not closed"};
    if (open_.size() == kMaxYamlDepth) {
      throw Stop{places_(mark), "nested deeper than " + std::to_string(kMaxYamlDepth) + " levels"};
    }
    open_.emplace_back().node.kind = kind;
    open_.back().node.place = places_(mark);
  }

  void close() {
    YamlNode node = std::move(open_.back().node);
    open_.pop_back();
    const Place place = node.place;
    attach(std::move(node), place);
  }

  bool awaits_key() const {
    return !open_.empty() && open_.back().node.kind == YamlNode::Kind::map && !open_.back().awaits_value;
  }

  void attach(YamlNode node, Place place) {
    if (++nodes_ > kMaxYamlNodes) throw Stop{place, "more than " + std::to_string(kMaxYamlNodes) + " values"};
    node.place = place;
    if (open_.empty()) {
      root = std::move(node);
      return;
    }
    Open& top = open_.back();
    if (awaits_key()) return take_key(top, std::move(node));
    if (!top.node.keys.empty() && node.kind == YamlNode::Kind::none) node.place = top.node.keys.back().place;
    top.awaits_value = false;
    top.node.items.push_back(std::move(node));
  }

  void take_key(Open& map, YamlNode key) {
    if (!key.is_text()) throw Stop{key.place, "a key is missing"};
    const auto [first, is_new] = map.seen.emplace(key.text, key.place);
    if (!is_new) {
      mistakes_.add(key.place, "the key " + api::shown_text(key.text) + " stands twice, first in line " +
                                   std::to_string(first->second.line) + ": leave one of the two out");
    }
    map.node.keys.push_back({std::move(key.text), key.place});
    map.awaits_value = true;
  }

  const Places& places_;
  Mistakes& mistakes_;
  std::vector<Open> open_;
  std::size_t nodes_ = 0;
  int documents_ = 0;
};

// Translates yaml-cpp's messages, which speak of its grammar. Later versions append text to some of them.
std::string explained(const std::string& message) {
  namespace words = YAML::ErrorMsg;
  const std::pair<std::string_view, std::string_view> known[] = {
      {words::MAP_VALUE,
       "a ':' stands where none can: indent the keys of one map alike, by blanks and not by tabs, and put a text with "
       "': ' in it in quotes"},
      {words::MAP_KEY, "a key stands where none can: indent the keys of one map alike, by blanks and not by tabs"},
      {words::END_OF_MAP, "a map ends in an unexpected way: indent its keys alike, and write 'key: value'"},
      {words::END_OF_SEQ, "a list ends in an unexpected way: indent its entries alike, each behind '- '"},
      {words::BLOCK_ENTRY, "a '- ' stands where no list can begin: put it on a line of its own below its key"},
      {words::END_OF_MAP_FLOW, "a '{' is not closed, or a ',' is missing; a text that begins with '{' goes in quotes"},
      {words::END_OF_SEQ_FLOW, "a '[' is not closed, or a ',' is missing; a text that begins with '[' goes in quotes"},
      {words::FLOW_END, "a ']' or '}' closes nothing: put a text with it in quotes"},
      {words::DOC_IN_SCALAR, "a quote is opened before this line and not closed"},
      {words::EOF_IN_SCALAR, "a quote is opened before this line and not closed"},
      {words::TAB_IN_INDENTATION, "a tab stands where the line is indented: use blanks"},
      {words::UNKNOWN_TOKEN, "no text can begin so in YAML: put it in quotes"},
      {words::UNKNOWN_ANCHOR, kNoAlias},
      {words::ALIAS_NOT_FOUND, kNoAlias},
      {words::CHAR_IN_ALIAS, kNoAlias},
      {words::ALIAS_CONTENT, kNoAlias}};
  const auto found =
      std::find_if(std::begin(known), std::end(known), [&](auto& pair) { return message.starts_with(pair.first); });
  if (found != std::end(known)) return std::string(found->second);
  std::string shown = "not YAML: " + message;  // some messages name the character
  std::replace_if(shown.begin(), shown.end(), is_control, '?');
  return shown;
}

// Refuses encodings and characters that yaml-cpp would misread silently.
void refuse_bytes(std::string_view text, const Places& places) {
  if (text.size() > kMaxYamlBytes) throw Stop{{}, "larger than " + std::to_string(kMaxYamlBytes) + " bytes"};
  if (const std::size_t bad = find_not_utf8(text); bad != std::string_view::npos) {
    throw Stop{places.at(bad), "not UTF-8: save the file in this encoding"};
  }
  const auto control = std::find_if(text.begin(), text.end(),
                                    [](char c) { return is_control(c) && c != '\n' && c != '\r' && c != '\t'; });
  if (control == text.end()) return;
  throw Stop{places.at(static_cast<std::size_t>(control - text.begin())),
             "a control character: remove it, or write it as an escape in double quotes"};
}

void read(std::string_view text, Builder& builder) {
  // yaml-cpp accepts an unclosed quote at the end of a file, but not at the end of a document.
  std::istringstream stream(std::string(text) + "\n...\n");
  YAML::Parser parser(stream);
  while (parser.HandleNextDocument(builder)) {
  }
}

}  // namespace

std::optional<YamlNode> parse_yaml(std::string_view text, Mistakes& mistakes) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  const Places places(text);
  Builder builder(places, mistakes);
  try {
    refuse_bytes(text, places);
    read(text, builder);
    return std::move(builder.root);
  } catch (const Stop& stop) {
    mistakes.add(stop.place, stop.message);
  } catch (const YAML::Exception& exception) {
    mistakes.add(places(exception.mark), explained(exception.msg));
  }
  return std::nullopt;
}

}  // namespace meshgauge::check
