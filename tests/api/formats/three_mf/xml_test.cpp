#include "api/formats/three_mf/xml.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

// The events of a document, as text.
class Events : public XmlHandler {
 public:
  void declare(std::string_view prefix, std::string_view name_space) override {
    text += std::string(prefix) + "=" + std::string(name_space) + ";";
  }
  std::optional<XmlDefect> start(const XmlName& name, const XmlAttributes& attributes) override {
    text += "<" + expanded(name);
    for (const XmlAttribute& one : attributes.prefixed()) text += " " + expanded(one.name) + ":" + one.value;
    for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
      if (!contains(pair[0], ":") && !contains(pair[0], "xmlns")) text += " " + std::string(pair[0]) + ":" + pair[1];
    }
    if (attributes.find("bad") == nullptr) return std::nullopt;
    return XmlDefect{ErrorCode::empty_mesh, "a bad attribute"};
  }
  void end() override { text += ">"; }

  std::string text;

 private:
  static std::string expanded(const XmlName& name) {
    return (name.space.empty() ? "" : std::string(name.space) + "\n") + std::string(name.local);
  }
};

// Accepts prefixes that are not declared.
class LenientEvents : public Events {
 public:
  std::optional<XmlDefect> undeclared(const XmlName& name) override {
    text += "?" + std::string(name.prefix()) + ";";
    return std::nullopt;
  }
};

struct Outcome {
  std::string text;
  std::string refusal;
};

template <class Handler = Events>
Outcome parsed(const std::string& document) {
  const std::string archive = zip({{"doc.xml", document}});
  const ReadLimits limits;
  const Source source{bytes_of(archive), "a", limits};
  auto opened = ZipArchive::open(source);
  REQUIRE(opened.ok());
  Handler events;
  const auto ok = read_xml(source, *opened, "doc.xml", events);
  return {events.text, ok ? "" : ok.error().message};
}

std::string refusal_of(const std::string& document) { return parsed(document).refusal; }

}  // namespace

TEST_CASE("xml: elements, attributes and namespaces") {
  CHECK(parsed("<?xml version='1.0'?><!-- c --><a x='1' y='&lt;&#65;'><b/>text<![CDATA[<c/>]]></a>\n").text ==
        "<a x:1 y:<A<b>>");
  CHECK(parsed("<a xmlns='u' xmlns:p='v'><p:b p:x='1' x='2'/></a>").text == "=u;p=v;<u\na<v\nb v\nx:1 x:2>>");
  CHECK(parsed("\xEF\xBB\xBF<a/>").text == "<a>");
  std::string wide("\xFE\xFF", 2);
  for (const char c : std::string("<a/>")) wide += {'\0', c};
  CHECK(parsed(wide).text == "<a>");
}

TEST_CASE("xml: a declaration holds for its element and those inside, the innermost first") {
  CHECK(parsed("<p:a xmlns:p='u'><p:b xmlns:p='v' xmlns='w'><c p:x='1'/></p:b><p:d/><e/></p:a>").text ==
        "p=u;<u\na"
        "p=v;=w;<v\nb"
        "<w\nc v\nx:1>>"
        "<u\nd><e>>");
  CHECK(parsed("<a xmlns='u'><b xmlns=''><c/></b><d/></a>").text == "=u;<u\na=;<b<c>><u\nd>>");
  CHECK(parsed("<a p:x='1' xmlns:p='u' xml:lang='en'/>").text ==
        "p=u;<a u\nx:1 http://www.w3.org/XML/1998/namespace\nlang:en>");
  CHECK(parsed("<a x='1' xmlns:p='u' p:x='2' xmlns:q='v' q:x='3'/>").text == "p=u;q=v;<a u\nx:2 v\nx:3 x:1>");
}

TEST_CASE("xml: names and declarations that XML does not allow are refused") {
  CHECK(contains(refusal_of("<a xmlns:p='u' xmlns:q='u' p:x='1' q:x='2'/>"), "not valid XML: duplicate attribute 'x'"));
  CHECK(contains(refusal_of("<a xmlns:p=''/>"), "the prefix 'p' is declared without a namespace"));
  CHECK(contains(refusal_of("<a xmlns:xml='u'/>"), "a reserved prefix or namespace is declared, 'xml'"));
  CHECK(contains(refusal_of("<a xmlns:xmlns='u'/>"), "'xmlns'"));
  CHECK(contains(refusal_of("<a xmlns:p='http://www.w3.org/2000/xmlns/'/>"), "reserved"));
  CHECK(contains(refusal_of("<a xmlns='http://www.w3.org/XML/1998/namespace'/>"), "reserved"));
  CHECK(refusal_of("<a xmlns:xml='http://www.w3.org/XML/1998/namespace'/>").empty());
  for (const char* name : {":a", "a:", "p:a:b"}) {
    CAPTURE(name);
    const std::string wrong = "the name '" + std::string(name) + "' has a colon out of place";
    CHECK(contains(refusal_of("<r xmlns:p='u'>\n<" + std::string(name) + "/></r>"),
                   "line 2 of 'a': not valid XML: " + wrong));
    CHECK(contains(refusal_of("<r xmlns:p='u' " + std::string(name) + "='1'/>"), wrong));
  }
  CHECK(contains(refusal_of("<r xmlns:='u'/>"), "the name 'xmlns:' has a colon out of place"));
  CHECK(contains(refusal_of("<r xmlns:a:b='u'/>"), "the name 'xmlns:a:b' has a colon out of place"));
}

TEST_CASE("xml: a prefix that is not declared is refused, unless the handler ignores it") {
  CHECK(contains(refusal_of("<a>\n<p:b/></a>"), "line 2 of 'a': not valid XML: the prefix of 'p:b' is not declared"));
  CHECK(contains(refusal_of("<a p:x='1'/>"), "the prefix of 'p:x' is not declared"));
  CHECK(contains(refusal_of("<a><b xmlns:p='u'/><p:c/></a>"), "the prefix of 'p:c' is not declared"));
  CHECK(parsed<LenientEvents>("<a><p:b q:x='1'/></a>").text == "<a?p;?q;<b x:1>>");
}

TEST_CASE("xml: namespaces are limited in length and number") {
  CHECK(refusal_of("<a xmlns='" + std::string(256, 'u') + "'/>").empty());
  CHECK(contains(refusal_of("<a xmlns='" + std::string(257, 'u') + "'/>"), "has more than 256 bytes"));
  const auto declaring = [](int count) {
    std::string tag = "<a";
    for (int i = 0; i < count; ++i) tag += " xmlns:p" + std::to_string(i) + "='u'";
    return tag + "/>";
  };
  CHECK(refusal_of("<r>" + declaring(10'000) + declaring(10'000) + "</r>").empty());
  CHECK(contains(refusal_of(declaring(10'001)), "more than 10000 namespaces at a time"));
}

TEST_CASE("xml: a document larger than any piece of it") {
  std::string document = "<a>";
  for (int i = 0; i < 50'000; ++i) document += "<b i='" + std::to_string(i) + "'/>";
  document += "</a>";
  CHECK(parsed(document).text.size() > 500'000);
  CHECK(contains(refusal_of(document + "<c/>"), "doc.xml, line 1 of 'a': not valid XML: junk after document element"));
}

TEST_CASE("xml: malformed documents are refused with their line") {
  CHECK(contains(refusal_of("<a>\n<b>\n</a>"), "doc.xml, line 3 of 'a': not valid XML: mismatched tag"));
  CHECK(contains(refusal_of("<a>\n"), "doc.xml, line 2 of 'a': not valid XML: no element found"));
  CHECK(contains(refusal_of(""), "no element found"));
  CHECK(contains(refusal_of("<a b='1' b='2'/>"), "duplicate attribute"));
  CHECK(contains(refusal_of("<a>&other;</a>"), "undefined entity"));
  CHECK(contains(refusal_of("<a>\n<b bad='1'/></a>"), "doc.xml, line 2 of 'a': a bad attribute"));
  CHECK(contains(refusal_of("<?xml version='1.0' encoding='EBCDIC'?><a/>"), "unknown encoding"));
}

TEST_CASE("xml: a document type is refused, and with it every entity") {
  const std::string laughs = "<!DOCTYPE a [<!ENTITY l 'lol'><!ENTITY m '&l;&l;&l;&l;&l;&l;&l;&l;&l;&l;'>]>\n<a>&m;</a>";
  CHECK(contains(refusal_of(laughs), "doc.xml, line 1 of 'a': a document type (DTD)"));
  CHECK(contains(refusal_of("<!DOCTYPE a [<!ENTITY x SYSTEM '/etc/passwd'>]><a b='&x;'/>"), "a document type"));
  CHECK(contains(refusal_of("<!DOCTYPE a SYSTEM 'http://127.0.0.1:9/a.dtd'><a/>"), "a document type"));
}

TEST_CASE("xml: nesting, long tags and the memory of names are limited") {
  std::string deep;
  for (int i = 0; i < 100'000; ++i) deep += "<a>";
  CHECK(contains(refusal_of(deep), "nested deeper than 64"));
  CHECK(contains(refusal_of("<a b='" + std::string(3'000'000, 'x') + "'/>"), "a tag or a comment of more than 1 MiB"));
  CHECK(
      contains(refusal_of("<!--" + std::string(3'000'000, 'x') + "--><a/>"), "a tag or a comment of more than 1 MiB"));
  CHECK(refusal_of("<a b='" + std::string(500'000, 'x') + "'/>").empty());
  CHECK(refusal_of("<a>" + std::string(5'000'000, 'x') + "</a>").empty());
  std::string names = "<a>";
  for (int i = 0; i < 1'500'000; ++i) names += "<n" + std::to_string(i) + "/>";
  CHECK(contains(refusal_of(names + "</a>"), "too many different names"));
}

}  // namespace meshgauge::api::test
