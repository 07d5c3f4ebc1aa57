#include "api/formats/xml.h"

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
  std::optional<XmlDefect> start(std::string_view name, const XmlAttributes& attributes) override {
    text += "<" + std::string(name);
    for (const char* const* pair = attributes.pairs(); *pair != nullptr; pair += 2) {
      text += " " + std::string(pair[0]) + ":" + pair[1];
    }
    if (attributes.find("bad") == nullptr) return std::nullopt;
    return XmlDefect{ErrorCode::empty_mesh, "a bad attribute"};
  }
  void end() override { text += ">"; }

  std::string text;
};

struct Outcome {
  std::string text;
  std::string refusal;
};

Outcome parsed(const std::string& document) {
  const std::string archive = zip({{"doc.xml", document}});
  const ReadLimits limits;
  const Source source{bytes_of(archive), "a", limits};
  auto opened = ZipArchive::open(source);
  REQUIRE(opened.ok());
  Events events;
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
  CHECK(contains(refusal_of("<a xmlns='u&#10;v'/>"),
                 "not valid XML"));  // otherwise "u" and "v\na" would look like "u\nv" and "a"
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
