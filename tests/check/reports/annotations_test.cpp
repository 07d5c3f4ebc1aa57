#include <filesystem>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "check/reports/finding.h"
#include "check/reports/reports.h"
#include "check/reports/sample_reports.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

struct Command {
  std::string name;
  std::map<std::string, std::string> properties{};
  std::string message{};
};

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + by.size()))
    text.replace(at, what.size(), by);
  return text;
}

// As GitHub's runner reads a value.
std::string unescaped(std::string text, bool is_property) {
  text = replaced(replaced(std::move(text), "%0D", "\r"), "%0A", "\n");
  if (is_property) text = replaced(replaced(std::move(text), "%3A", ":"), "%2C", ",");
  return replaced(std::move(text), "%25", "%");
}

// As GitHub's runner reads a line of the log; nullopt: it is no command.
std::optional<Command> command_in(const std::string& line) {
  if (!line.starts_with("::")) return std::nullopt;
  const std::size_t end = line.find("::", 2);
  if (end == std::string::npos) return std::nullopt;
  const std::string head = line.substr(2, end - 2);
  const std::size_t blank = head.find(' ');
  Command command{head.substr(0, blank)};
  command.message = unescaped(line.substr(end + 2), false);
  std::istringstream properties(blank == std::string::npos ? "" : head.substr(blank + 1));
  for (std::string one; std::getline(properties, one, ',');) {
    const std::size_t equals = one.find('=');
    if (equals == std::string::npos) continue;
    command.properties[one.substr(0, equals)] = unescaped(one.substr(equals + 1), true);
  }
  return command;
}

std::vector<Command> commands_in(const std::string& text) {
  std::vector<Command> commands;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    auto command = command_in(line);
    REQUIRE_MESSAGE(command, line);
    commands.push_back(*std::move(command));
  }
  return commands;
}

}  // namespace

TEST_CASE("annotations: a command for each gate that does not pass, the worst first") {
  const std::vector<Command> commands = commands_in(to_annotations(samples::ordinary()));
  REQUIRE(commands.size() == 4);
  CHECK(commands[0].properties.at("title") == "meshgauge: screw");
  CHECK(commands[1].name == "error");
  CHECK(commands[1].properties ==
        std::map<std::string, std::string>{{"file", "parts/gates.yaml"}, {"line", "7"}, {"title", "meshgauge: lid"}});
  CHECK(commands[1].message == description_of(samples::failed("lid")));
  CHECK(commands[2].properties.at("title") == "meshgauge: hinge");
  CHECK(commands[3].name == "warning");
  Report allowed = samples::report_of({samples::undecided("hinge")});
  allowed.undecided = Undecided::warn;
  CHECK(commands_in(to_annotations(allowed)).at(0).name == "notice");
  CHECK(to_annotations(samples::report_of({samples::passed("a")})).empty());
}

TEST_CASE("annotations: what was not measured of a gate that passes is a notice") {
  GateOutcome outcome = samples::passed("a");
  outcome.gate.notes = {"'parts/.b.stl' is passed over"};
  const std::vector<Command> commands = commands_in(to_annotations(samples::report_of({outcome})));
  REQUIRE(commands.size() == 1);
  CHECK(commands[0].name == "notice");
  CHECK(commands[0].message.find("is passed over") != std::string::npos);
}

TEST_CASE("annotations: names cannot end a line, a property or a command") {
  const auto alone = [](const std::string& name) {
    GateOutcome outcome = samples::failed(name);
    outcome.gate.manifest = name;
    return samples::report_of({outcome});
  };
  std::vector<std::string> names = samples::hostile_names();
  for (const char* more : {"::error file=x::y", "a,line=1,title=b::c", "%0A::warning::x", "a%2Cb%25", "##[error]x"})
    names.emplace_back(more);
  for (const std::string& name : names) {
    const Report report = alone(name);
    const std::vector<Command> commands = commands_in(to_annotations(report));
    REQUIRE(commands.size() == 1);
    CHECK(commands[0].name == "error");
    CHECK(commands[0].properties.size() == 3);
    CHECK(commands[0].properties.at("line") == "7");
    if (name.size() < 1000) CHECK(commands[0].message == description_of(report.outcomes[0]));
  }
  CHECK(commands_in(to_annotations(alone("a,b%2C:c"))).at(0).properties.at("file") == "a,b%2C:c");
}

TEST_CASE("annotations: ten of each, the last one counts the others") {
  std::vector<GateOutcome> many;
  for (int i = 0; i < 12; ++i) many.push_back(samples::failed("gate-" + std::to_string(i)));
  many.push_back(samples::broken("screw"));
  for (int i = 0; i < 10; ++i) {
    many.push_back(samples::failed("warned-" + std::to_string(i)));
    many.back().gate.warn_only = true;
  }
  const std::vector<Command> commands = commands_in(to_annotations(samples::report_of(many)));
  REQUIRE(commands.size() == 20);
  CHECK(commands[0].properties.at("title") == "meshgauge: screw");
  CHECK(commands[9].name == "error");
  CHECK(commands[9].message.starts_with("4 more gates"));
  CHECK(commands[10].name == "warning");
  CHECK(commands[19].properties.at("title") == "meshgauge: warned-9");
}

TEST_CASE("annotations: files are named from the folder of the repository, and a mistake of flags has none") {
  GateOutcome outcome = samples::failed("lid");
  outcome.gate.manifest = "/w/parts/sub/../gates.yaml";
  const Report report = samples::report_of({outcome});
  const auto file = [](const Report& of, const std::filesystem::path& top) {
    return commands_in(to_annotations(of, top)).at(0).properties.at("file");
  };
  CHECK(file(report, "/w/parts") == "gates.yaml");
  CHECK(file(report, "/w/parts/") == "gates.yaml");
  CHECK(file(report, "/elsewhere") == "/w/parts/gates.yaml");
  CHECK(file(report, "") == "/w/parts/gates.yaml");
  CHECK(file(samples::report_of({samples::failed("lid")}), std::filesystem::current_path().parent_path()) ==
        (std::filesystem::current_path().filename() / "parts/gates.yaml").string());
  const auto commands = commands_in(to_annotations(mistaken("", {{0, 0, "--only: is empty"}})));
  CHECK(commands.at(0).properties.count("file") == 0);
  CHECK(commands.at(0).message.find("--only: is empty") != std::string::npos);
}
