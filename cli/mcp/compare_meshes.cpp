// The tool compare_meshes: a verdict, an interval and a picture of two meshes.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <limits>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "api/base/figures.h"
#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/compare/compare.h"
#include "api/formats/unread.h"
#include "api/options/write_options.h"
#include "api/result/criteria.h"
#include "api/result/examination.h"
#include "api/result/notes.h"
#include "api/result/response.h"
#include "api/result/result_document.h"
#include "check/html/picture.h"
#include "check/outcome.h"
#include "check/reports/wording.h"
#include "cli/mcp/options_schema.h"
#include "cli/mcp/tool.h"
#include "engine/thread_pool.h"

namespace meshgauge::mcp {
namespace {

constexpr std::chrono::milliseconds kTellEvery{250};

// Members of a result document that an answer has, too, where the document has them.
constexpr const char* kKept[] = {"verdict",   "foremost", "criteria",     "distance",   "unit",
                                 "direction", "status",   "notes",        "alignment",  "regions",
                                 "areas",     "sides",    "share_beyond", "statistics", "meshes"};

struct Asked {
  MeshArgument a, b;
  api::Request request;
  std::optional<bool> picture;  // nullopt: where the verdict is not pass
};

Json compare_input() {
  return object_schema(
      {{"a", mesh_schema("Mesh a, the candidate: what is judged")},
       {"b", mesh_schema("Mesh b, the baseline: what it is compared with")},
       {"options", options_schema()},
       {"picture", schema_of("boolean", "Whether to add a picture; by default where the verdict is not pass")}},
      {"a", "b"});
}

Json compare_output() {
  const Json number_or_null = {"number", "null"}, text_or_null = {"string", "null"};
  const Json interval = {
      {"type", "object"},
      {"properties",
       {{"lower", schema_of("number", "The distance is at least this")},
        {"upper", schema_of(number_or_null, "The distance is at most this; null: no bound is known")}}},
      {"required", {"lower", "upper"}}};
  Json schema{{"type", "object"}, {"properties", Json::object()}};
  Json& found = schema["properties"];
  found["verdict"] = schema_of(text_or_null, "pass, fail or undecided; null: nothing was limited or expected");
  found["foremost"] = schema_of(text_or_null, "The name of the criterion to look at first");
  found["criteria"] = schema_of("array", "Each limit and expectation with its verdict, the foremost first");
  found["distance"] = interval;
  found["unit"] = schema_of("object", "The unit of all lengths: its name, or null, and its source");
  found["direction"] = schema_of("string", "From which mesh the distance was measured");
  found["status"] = schema_of("string", "Why the work ended: converged, gate_decided, timeout, ...");
  found["witness"] = schema_of({"object", "null"}, "Two points whose distance is the lower bound, one on each mesh");
  found["notes"] = schema_of("array", "What was converted or moved, what looks like a wrong unit");
  found["meshes"] = schema_of("object", "Facts of both files");
  schema["required"] = {"verdict", "criteria", "distance", "unit", "status", "witness", "notes", "meshes"};
  return schema;
}

// --- what is asked ----------------------------------------------------------------------------------------------

void read_options(const nlohmann::json& options, const Context& context, api::Reading& reading, api::Request& request) {
  api::ReadRequest read = api::read_request(options, kToolOptions, context.times);
  for (api::RequestMistake& mistake : read.mistakes) {
    if (!mistake.pointer.empty()) mistake.pointer.insert(0, "/options");
    reading.mistakes.push_back(std::move(mistake));
  }
  request = std::move(read.request);
}

// Takes the arguments, whose bytes may be many, out of the call.
Asked read_asked(const Context& context, ToolCall& call, std::vector<api::RequestMistake>& mistakes) {
  const nlohmann::json arguments = std::exchange(call.arguments, nullptr);
  Asked asked;
  api::Reading reading(kArguments);
  const api::Reading::Member members[] = {
      {"a", [&](const auto& value, const std::string& at) { asked.a = read_mesh_argument(value, at, reading); }},
      {"b", [&](const auto& value, const std::string& at) { asked.b = read_mesh_argument(value, at, reading); }},
      {"options", [](const auto&, const std::string&) {}},  // below, as they are also read where they are missing
      {"picture", [&](const auto& value, const std::string& at) { asked.picture = reading.boolean(value, at); }}};
  reading.members(arguments, members, "");
  for (const char* mesh : {"a", "b"}) {
    if (!arguments.contains(mesh)) reading.refuse(std::string("/") + mesh, "is missing: name a mesh");
  }
  const auto options = arguments.find("options");
  read_options(options == arguments.end() ? nlohmann::json::object() : *options, context, reading, asked.request);
  mistakes = reading.told();
  return asked;
}

// --- what was found ---------------------------------------------------------------------------------------------

// An outcome, and what is said of the whole distance: where there are regions, the outcome's distance is the rest's.
struct Judged {
  check::GateOutcome outcome;
  std::optional<api::ResultWitness> farthest;            // two points whose distance is the lower bound
  std::string marked{"the point that is farthest off"};  // what Measured::witness is, which pictures have a mark on
  bool is_shown_against_limit = false;                   // the colours of pictures
};

// Without a place of a criterion, the mark is on the point that is farthest off.
void choose_mark(const api::ResultFacts& whole, check::Measured& measured, Judged& judged) {
  const bool passes = measured.verdict == check::Verdict::pass;
  const api::Criterion* const place = passes ? nullptr : api::foremost_place(measured.criteria);
  if (!place || !place->at->nearest) {
    measured.witness = whole.witness;
    measured.reached = whole.lower;
  } else if (place->name != "distance") {
    judged.marked = "the point to look at of '" + place->name + "'";
  }
}

// Without limits the criteria are empty. Without a limit to show pictures show distances up to the largest one.
Result<Judged> judged_of(const api::Comparison& comparison, const Json& document, const api::Request& request) {
  const auto whole = api::result_facts(document, api::Side::a);
  if (!whole) return whole.error();
  Judged judged;
  judged.farthest = whole->witness;
  check::GateOutcome& outcome = judged.outcome;
  outcome.gate.name = "comparison";
  outcome.gate.request = request;
  outcome.expectations = api::expectations_of(comparison);
  check::Measured& measured = outcome.measured.emplace();
  if (has_limit(request.options)) {
    auto limited = check::measured_from(document, outcome.gate);
    if (!limited) return limited.error();
    measured = std::move(*limited);
    choose_mark(*whole, measured, judged);
  } else {
    static_cast<api::ResultFacts&>(measured) = *whole;
    measured.document = document;
  }
  judged.is_shown_against_limit = measured.limit.has_value();
  if (!measured.limit) measured.limit = api::DistanceLimit{std::isfinite(whole->upper) ? whole->upper : whole->lower};
  return judged;
}

Json witness_json(const std::optional<api::ResultWitness>& witness) {
  if (!witness) return nullptr;
  return {{"on", witness->on_candidate ? "a" : "b"},
          {"point", api::json_of(witness->from)},
          {"triangle", witness->from_triangle},
          {"nearest_point", api::json_of(witness->to)},
          {"nearest_triangle", witness->to_triangle}};
}

Json found_of(const Json& document, const Judged& judged) {
  Json found = Json::object();
  for (const char* member : kKept) {
    const auto there = document.find(member);
    if (there == document.end() || (there->is_null() && member == std::string_view("statistics"))) continue;
    found[member] = *there;
  }
  put_first(found["criteria"], document.at("foremost"));
  found["witness"] = witness_json(judged.farthest);
  return found;
}

// --- in words ---------------------------------------------------------------------------------------------------

std::string place_in_words(const api::ResultWitness& witness, std::string_view unit) {
  const char* const on = witness.on_candidate ? "a" : "b";
  const char* const other = witness.on_candidate ? "b" : "a";
  return "farthest off is " + api::with_unit(api::in_words(witness.from), unit) + " on triangle " +
         std::to_string(witness.from_triangle) + " of mesh " + on + ", nearest to " +
         api::with_unit(api::in_words(witness.to), unit) + " on triangle " + std::to_string(witness.to_triangle) +
         " of mesh " + other;
}

void add_line(std::string& text, const std::string& line) { text += check::shown_text(line) + "\n"; }

// What was not read of a mesh was not measured, either.
void add_unread(std::string& text, const char* mesh, const api::MeshFacts& facts) {
  for (const std::string& note : api::notes_of(facts)) {
    if (note.starts_with(api::Unread::kRemark)) add_line(text, std::string("note: mesh ") + mesh + ": " + note);
  }
}

// What to do. A gate says that it may be changed, and a call has no gate.
std::string what_to_do(const check::GateOutcome& outcome) {
  if (!has_limit(outcome.gate.request.options)) return "";
  const bool is_of_expectation = outcome.measured->verdict != check::Verdict::fail;
  if (outcome.verdict() == check::Verdict::fail && is_of_expectation)
    return "Repair mesh a, or change what is expected of it.";
  return outcome.advice();
}

std::string sentences_of(const api::Comparison& comparison, const Judged& judged, const Json& document) {
  const std::string unit(api::to_string(comparison.units.result.unit));
  std::string text;
  for (const api::Criterion& one : api::foremost_first(api::criteria_of(comparison)))
    add_line(text, std::string(api::to_string(one.verdict)) + ": " + api::finding_of(one, unit));
  const api::IntervalText figures =
      api::to_text(comparison.outcome.lower, comparison.outcome.upper, std::numeric_limits<double>::infinity());
  add_line(text, "the distance (" + document.at("direction").get<std::string>() + ") is from " + figures.lower +
                     " to " + api::with_unit(figures.upper, unit));
  const std::string advice = what_to_do(judged.outcome);
  if (!advice.empty()) add_line(text, advice);
  if (judged.farthest && advice.find(api::in_words(judged.farthest->from)) == std::string::npos)
    add_line(text, place_in_words(*judged.farthest, unit));
  for (const Json& note : document.at("notes")) add_line(text, "note: " + note.get<std::string>());
  add_unread(text, "a", comparison.a);
  add_unread(text, "b", comparison.b);
  return text;
}

bool wants_picture(const Asked& asked, const Json& document) {
  const Json& verdict = document.at("verdict");
  return asked.picture.value_or(!verdict.is_null() && verdict != "pass");
}

// Returns a PNG, or why there is none.
Result<std::vector<std::byte>> picture_of(const check::GateOutcome& outcome, const api::SharedMeshes& meshes,
                                          ToolCall& call) try {
  const check::Measured& measured = *outcome.measured;
  const auto pair = api::in_unit_of_result(meshes.a, meshes.b, measured.units, measured.motion, call.control);
  if (!pair) return pair.error();
  ThreadPool pool(call.threads);
  check::GatePicture picture = check::make_picture(*pair->a, *pair->b, outcome, pool, call.control, {false, true});
  if (picture.strip.empty()) return refused(picture.missing);
  return std::move(picture.strip);
} catch (const std::bad_alloc&) {
  return refused("there is not enough memory for it");
}

// Has a time of its own, since that of the measurement may be over.
void add_picture(const Context& context, const Judged& judged, const api::SharedMeshes& meshes, ToolCall& call,
                 ToolAnswer& answer) {
  call.control.exchange_callback(nullptr);
  call.control.set_deadline(Control::Clock::now() + context.times.default_timeout);
  auto picture = picture_of(judged.outcome, meshes, call);
  if (!picture) return add_line(answer.text, "there is no picture: " + picture.error().message);
  add_line(answer.text,
           std::string("the picture shows mesh b (before), mesh a (after), and both coloured by their distance "
                       "(difference); ") +
               (judged.is_shown_against_limit ? "dark red is beyond the limit" : "red is the largest distance") +
               (judged.outcome.measured->witness ? ", the mark is on " + judged.marked : ""));
  answer.png = std::move(*picture);
}

// --- the work ---------------------------------------------------------------------------------------------------

void tell_progress(ToolCall& call) {
  if (!call.progress) return;
  call.control.watch(
      [tell = call.progress, steps = 0.0](const Progress& progress) mutable {
        tell(++steps, 0,
             std::string(progress.stage) + ": " + api::shortest(progress.lower) + " .. " +
                 api::shortest(progress.upper));
      },
      kTellEvery);
}

Result<api::Comparison> compared(const Context& context, const api::MeshInput& a, const api::MeshInput& b,
                                 const api::Request& request, ToolCall& call, api::SharedMeshes& meshes) {
  api::ComparisonOptions options = request.options;
  options.threads = request.threads_given ? std::min(options.threads, context.processors) : call.threads;
  call.control.set_deadline(Control::Clock::now() + request.timeout);
  tell_progress(call);
  return api::compare(a, b, options, context.confines->limits, call.control, &meshes);
}

ToolAnswer run_compare(const Context& context, ToolCall& call) {
  std::vector<api::RequestMistake> mistakes;
  Asked asked = read_asked(context, call, mistakes);
  if (!mistakes.empty()) return failure(mistakes);
  const auto a = GivenMesh::open(std::move(asked.a), "a", *context.confines);
  if (!a) return failure(a.error());
  const auto b = GivenMesh::open(std::move(asked.b), "b", *context.confines);
  if (!b) return failure(b.error());
  api::SharedMeshes meshes;
  const auto comparison = compared(context, a->input(), b->input(), asked.request, call, meshes);
  if (!comparison) return failure(comparison.error());
  const Json document = api::document_of(*comparison);
  const auto judged = judged_of(*comparison, document, asked.request);
  if (!judged) return failure(judged.error());
  ToolAnswer answer{sentences_of(*comparison, *judged, document), found_of(document, *judged), {}};
  if (wants_picture(asked, document)) add_picture(context, *judged, meshes, call, answer);
  return answer;
}

}  // namespace

constinit const Tool kCompareMeshes{
    "compare_meshes",
    "Compare two meshes",
    "Measures how far apart two triangle meshes are (the Hausdorff distance) as an interval that is certain, and "
    "judges it by limits: pass, fail or undecided. Names the point that is farthest off and shows it in a picture. Use "
    "it to check a generated or changed part against a reference.",
    compare_input,
    compare_output,
    run_compare};

}  // namespace meshgauge::mcp
