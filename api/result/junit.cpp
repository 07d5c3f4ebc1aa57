#include "api/result/junit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "api/base/text.h"
#include "api/base/utc.h"
#include "api/base/utf8.h"

namespace meshgauge::api {
namespace {

// XML allows neither most control characters nor U+FFFE and U+FFFF, not even as character references.
std::string escaped(std::string text) {
  for (char& c : text) {
    if (is_control(c) && c != '\n') c = '?';
  }
  constexpr std::pair<std::string_view, std::string_view> kWritten[] = {
      {"\xEF\xBF\xBE", "?"}, {"\xEF\xBF\xBF", "?"}, {"&", "&amp;"}, {"<", "&lt;"}, {">", "&gt;"}, {"\"", "&quot;"}};
  for (const auto& [what, by] : kWritten) replace_all(text, what, by);
  return text;
}

// XML readers turn a line end in an attribute into a blank, so it is written as a reference.
std::string attribute(const std::string& name, const std::string& value) {
  std::string text = escaped(value);
  replace_all(text, "\n", "&#10;");
  return " " + name + "=\"" + text + "\"";
}

std::string attribute(const std::string& name, std::size_t value) { return attribute(name, std::to_string(value)); }

std::string in_seconds(double seconds) {
  std::array<char, 64> text{};
  const double s = std::isfinite(seconds) ? std::clamp(seconds, 0.0, 1e9) : 0;
  return {text.begin(), std::to_chars(text.begin(), text.end(), s, std::chars_format::fixed, 3).ptr};
}

// Returns UTC without its "Z", which the schema does not allow.
std::string timestamp(std::chrono::system_clock::time_point when) { return to_utc(when).substr(0, 19); }

}  // namespace

std::string junit_class(std::string name) {
  std::replace(name.begin(), name.end(), '.', '_');
  return "meshgauge." + name;
}

std::string junit_begin() { return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n"; }

std::string junit_suite(const JUnitSuite& suite) {
  std::string xml = "  <testsuite" + attribute("name", suite.name) + attribute("package", suite.package) +
                    attribute("id", suite.id) + attribute("timestamp", timestamp(suite.when)) +
                    attribute("hostname", "localhost") +  // required; the machine's name is private
                    attribute("tests", suite.tests) + attribute("failures", suite.failures) +
                    attribute("errors", suite.errors) + attribute("time", in_seconds(suite.seconds)) +
                    ">\n    <properties>\n";
  for (const auto& [name, value] : suite.properties) {
    xml += "      <property" + attribute("name", name) + attribute("value", value) + " />\n";
  }
  return xml + "    </properties>\n";
}

std::string junit_case(const JUnitCase& test) {
  std::string xml = "    <testcase" + attribute("name", test.name) + attribute("classname", test.class_name) +
                    attribute("time", in_seconds(test.seconds));
  if (!test.defect) return xml + " />\n";
  const std::string element = test.defect->element;
  return xml + ">\n      <" + element + attribute("message", test.defect->message) +
         attribute("type", test.defect->type) + ">" + escaped(test.defect->text) + "</" + element +
         ">\n    </testcase>\n";
}

std::string junit_suite_end(const std::string& out) {
  return "    <system-out>" + escaped(out) + "</system-out>\n    <system-err />\n  </testsuite>\n";
}

std::string junit_end() { return "</testsuites>\n"; }

}  // namespace meshgauge::api
