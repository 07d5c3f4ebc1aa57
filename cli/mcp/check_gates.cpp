// The tool check_gates: a manifest of gates, as `meshgauge check` runs it.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/json_filter.h"
#include "api/result/criteria.h"
#include "check/manifest/manifest.h"
#include "check/outcome.h"
#include "check/reports/wording.h"
#include "check/run/json_report.h"
#include "check/run/local.h"
#include "check/run/meshes.h"
#include "check/run/run.h"
#include "check/run/terminal.h"
#include "cli/mcp/tool.h"

namespace meshgauge::mcp {
namespace {

constexpr const char* kUsualManifest = "gates.yaml";
constexpr std::size_t kMostLines = 20;           // of gates in words: of more those alone that do not pass
constexpr std::size_t kMostPatterns = 64;        // of `only`
constexpr std::size_t kMostGateBytes = 1 << 20;  // of all gates: a client takes an answer of 10 MB at most
constexpr std::size_t kMostTextBytes = 1 << 16;  // of the same in words

struct AskedGates {
  std::string manifest = kUsualManifest;
  std::vector<std::string> only;
  bool comparisons = false;
};

Json gates_input() {
  Json only = schema_of("array", "Names of gates, or patterns of *, ? and [..]; by default all gates");
  only["items"] = schema_of("string", "A name or a pattern");
  return object_schema(
      {{"manifest", schema_of("string", "The file that lists the gates, below a root; by default gates.yaml")},
       {"only", std::move(only)},
       {"comparisons", schema_of("boolean", "Whether each gate has its whole comparison, too; by default false")}},
      {});
}

Json gates_output() {
  Json schema{{"type", "object"}, {"properties", Json::object()}};
  Json& found = schema["properties"];
  found["verdict"] = schema_of("string", "Of all gates: pass, fail, undecided or error, as exit_code has it");
  found["exit_code"] = schema_of("integer", "0 pass, 1 fail, 2 undecided, 3 error");
  found["counts"] = schema_of("object", "Number of gates by their verdict");
  found["gates"] = schema_of("array", "Each gate with verdict, criteria (the foremost first), witness and advice");
  found["left_out"] = schema_of("integer", "Number of gates that found no room in the answer, passing ones first");
  schema["required"] = {"verdict", "exit_code", "counts", "gates", "left_out"};
  return schema;
}

void read_only(const nlohmann::json& value, const std::string& at, api::Reading& reading, AskedGates& asked) {
  reading.elements(
      value, 1, kMostPatterns, "names",
      [&](const nlohmann::json& one, const std::string& place) {
        const auto pattern = reading.text(one, place);
        if (pattern && pattern->empty()) reading.refuse(place, "is empty: name gates");
        asked.only.push_back(pattern.value_or(""));
      },
      at);
}

AskedGates read_gates(const nlohmann::json& arguments, std::vector<api::RequestMistake>& mistakes) {
  AskedGates asked;
  api::Reading reading(kArguments);
  const api::Reading::Member members[] = {
      {"manifest",
       [&](const auto& value, const std::string& at) { asked.manifest = reading.text(value, at).value_or(""); }},
      {"only", [&](const auto& value, const std::string& at) { read_only(value, at, reading, asked); }},
      {"comparisons", [&](const auto& value, const std::string& at) {
         asked.comparisons = reading.boolean(value, at).value_or(false);
       }}};
  reading.members(arguments, members, "");
  mistakes = reading.told();
  return asked;
}

// Selects gates by name. Each pattern must match one: else a misspelt one would silently leave its gates out.
void keep_only(const std::vector<std::string>& only, check::Gates& read) {
  for (std::size_t i = 0; i < only.size(); ++i) {
    const check::Selection one({only[i]});
    if (std::ranges::any_of(read.gates, [&](const check::Gate& gate) { return one.holds(gate.name); })) continue;
    read.mistakes.push_back(
        {0, 0, "/only/" + std::to_string(i) + ": no gate has a name that matches " + api::shown_text(only[i])});
  }
  const check::Selection all(only);
  std::erase_if(read.gates, [&](const check::Gate& gate) { return !all.holds(gate.name); });
}

// Leaves out lines of a long text before its last one, which has the counts of a table.
std::string shortened(const std::string& text) {
  if (text.size() <= kMostTextBytes) return text;
  const std::size_t last = text.rfind('\n', text.size() - 2) + 1;  // 0: there is one line
  const std::size_t end = std::min(last, text.rfind('\n', kMostTextBytes - 1) + 1);
  const auto lines = std::ranges::count(std::string_view(text).substr(end, last - end), '\n');
  return text.substr(0, end) + "(" + std::to_string(lines) + " lines are left out)\n" + text.substr(last);
}

ToolAnswer failure_of(const std::string& manifest, const std::vector<check::Mistake>& mistakes) {
  std::string text;
  for (const check::Mistake& mistake : mistakes) {
    const bool has_place = mistake.line > 0;
    text += (text.empty() ? "" : "\n") +
            check::shown_name(has_place ? check::to_string(manifest, mistake) : mistake.message);
  }
  return {shortened(text), nullptr, {}};
}

// A call has its place until its files are read, also when it is cancelled or their time is over: else readers that
// are not counted would add up.
struct UntilRead {
  ~UntilRead() { meshes.stop(); }
  check::Meshes& meshes;
};

check::Report report_of(const std::vector<check::Gate>& gates, ToolCall& call) {
  const auto meshes = std::make_shared<check::Meshes>(gates);
  const UntilRead until_read{*meshes};
  const auto measurer = check::local(gates, meshes, {call.threads, 0});
  check::Watch watch;
  watch.interrupted = [&] { return call.control.cancelled(); };
  watch.ended = [&](const check::GateOutcome& outcome, const check::Standing& standing) {
    if (!call.progress) return;
    call.progress(static_cast<double>(standing.done), static_cast<double>(standing.gates),
                  check::shown_name(outcome.gate.name) + ": " + std::string(check::to_string(outcome.verdict())));
  };
  return check::run(gates, *measurer, watch);
}

// Leaves out gates from the end, first those that pass, until the others have room.
std::size_t make_room(Json::array_t& gates) {
  std::vector<std::size_t> bytes;
  std::size_t all = 0;
  for (const Json& gate : gates) {
    bytes.push_back(gate.dump(-1, ' ', false, Json::error_handler_t::replace).size());
    all += bytes.back();
  }
  std::size_t left_out = 0;
  for (const bool passing : {true, false}) {
    for (std::size_t i = gates.size(); i-- > 0 && all > kMostGateBytes;) {
      if (gates[i].is_null() || (gates[i].at("verdict") == "pass") != passing) continue;
      all -= bytes[i];
      gates[i] = nullptr;
      ++left_out;
    }
  }
  std::erase_if(gates, [](const Json& gate) { return gate.is_null(); });
  return left_out;
}

Json found_in(const check::Report& report, bool comparisons) {
  Json found = Json::parse(check::to_json(report));
  auto& gates = found.at("gates").get_ref<Json::array_t&>();
  for (std::size_t i = 0; i < gates.size(); ++i) {
    const auto criteria = report.outcomes[i].criteria();
    if (!criteria.empty()) put_first(gates[i].at("criteria"), api::foremost(criteria).name);
    if (!comparisons) gates[i].erase("comparison");
  }
  found["left_out"] = make_room(gates);
  constexpr const char* kByExitCode[] = {"pass", "fail", "undecided", "error"};
  found["verdict"] = kByExitCode[report.exit_code()];
  return found;
}

std::string gates_in_words(const check::Report& report) {
  const bool is_long = report.outcomes.size() > kMostLines;
  const std::string table = check::to_table(report, {false, is_long, 0});
  return table.empty() ? "all " + std::to_string(report.outcomes.size()) + " gates pass\n" : shortened(table);
}

ToolAnswer run_gates(const Context& context, ToolCall& call) {
  std::vector<api::RequestMistake> mistakes;
  const AskedGates asked = read_gates(call.arguments, mistakes);
  if (!mistakes.empty()) return failure(mistakes);
  call.control.set_deadline(Control::Clock::now() + context.times.max_timeout);  // each gate has a time of its own
  check::Gates read = check::gates_within(context.confines, asked.manifest, check::Selection(asked.only),
                                          [&] { return call.control.check() != Interruption::none; });
  if (read.mistakes.empty()) keep_only(asked.only, read);
  if (!read.mistakes.empty()) return failure_of(asked.manifest, read.mistakes);
  const check::Report report = report_of(read.gates, call);
  return {gates_in_words(report), found_in(report, asked.comparisons), {}};
}

}  // namespace

constinit const Tool kCheckGates{
    "check_gates",
    "Check all gates of a manifest",
    "Runs the quality gate `meshgauge check`: measures each candidate of a gates.yaml against its baseline and judges "
    "it by its limits. Says which gates pass, which fail, where, and what to do.",
    gates_input,
    gates_output,
    run_gates};

}  // namespace meshgauge::mcp
