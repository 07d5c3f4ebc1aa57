// Writes JUnit XML. Valid for any UTF-8 text by the schema of Ant's reports (windyroad's JUnit.xsd, the strictest) and
// by that of Jenkins.
//
//   junit_begin() + (junit_suite() + junit_case()... + junit_suite_end())... + junit_end()
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace meshgauge::api {

struct JUnitSuite {
  std::string name;
  std::string package;
  std::size_t id = 0;
  std::chrono::system_clock::time_point when;
  std::size_t tests = 1;
  std::size_t failures = 0;
  std::size_t errors = 0;
  double seconds = 0;
  std::vector<std::pair<std::string, std::string>> properties = {};
};

struct JUnitDefect {
  const char* element = "";  // "failure" or "error"
  std::string type;
  std::string message;
  std::string text;
};

struct JUnitCase {
  std::string name;
  std::string class_name;
  double seconds = 0;
  std::optional<JUnitDefect> defect;
};

// Returns "meshgauge.NAME", dots in NAME replaced by '_': viewers take the text before the last dot as a package.
std::string junit_class(std::string name);

std::string junit_begin();
std::string junit_suite(const JUnitSuite& suite);
std::string junit_case(const JUnitCase& test);
std::string junit_suite_end(const std::string& out = "");  // `out`: the suite's output
std::string junit_end();

}  // namespace meshgauge::api
