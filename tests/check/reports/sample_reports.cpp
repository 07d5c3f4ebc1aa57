#include "check/reports/sample_reports.h"

#include <limits>
#include <utility>

#include "check/criteria.h"

namespace meshgauge::check::samples {
namespace {

GateOutcome outcome_of(const std::string& name, double lower, double upper, double limit, const char* status) {
  GateOutcome outcome;
  outcome.gate.name = name;
  outcome.gate.candidate = "build/" + name + ".stl";
  outcome.gate.baseline = "baselines/" + name + ".stl";
  set_limit(outcome.gate, limit, LengthUnit::millimeter);
  outcome.gate.manifest = "parts/gates.yaml";
  outcome.gate.line = 7;
  outcome.wall_ms = 1234.5678;
  Measured measured;
  set_criteria(measured, {distance(lower, upper, limit, status)});
  measured.witness = Witness{true, {1.5, -2, 0.1 + 0.2}, 17, {1.5, -2, 1e-9}, 4};
  outcome.measured = std::move(measured);
  return outcome;
}

}  // namespace

GateOutcome passed(const std::string& name) { return outcome_of(name, 0.001, 0.0123, 0.05, "gate_decided"); }
GateOutcome failed(const std::string& name) { return outcome_of(name, 0.0968, 0.0977, 0.05, "gate_decided"); }
GateOutcome undecided(const std::string& name) { return outcome_of(name, 0.04, 0.06, 0.05, "timeout"); }

GateOutcome broken(const std::string& name) {
  GateOutcome outcome = passed(name);
  outcome.measured.reset();
  outcome.error = Error{ErrorCode::unreadable_mesh, "'" + name + "' has no facet", "a", "line 3"};
  return outcome;
}

GateOutcome area(const std::string& name, double more) {
  GateOutcome outcome = outcome_of(name, 0.06, 0.07, 0.05, "converged");
  set_area_limit(outcome.gate, {0.05, 0.01});
  set_criteria(*outcome.measured, {share(0.05, 0.01, 0.00201234 + more, 0.00269876 + more)});
  return outcome;
}

GateOutcome zone(const std::string& name) {
  GateOutcome outcome = outcome_of(name, 0.06, 0.07, 0.05, "converged");
  outcome.gate.request.options.max_distance.reset();
  outcome.gate.request.options.zone = SideOptions::Limits{0.05, 0.1};
  Measured& measured = *outcome.measured;
  set_criteria(measured, {on_side("inside", distance(0.06, 0.07, 0.05, "complete")),
                          on_side("outside", distance(0.01, 0.02, 0.1, "complete"))});
  measured.limit = api::DistanceLimit{0.05, "inside"};
  return outcome;
}

Report report_of(std::vector<GateOutcome> outcomes) {
  Report report;
  report.outcomes = std::move(outcomes);
  report.version = "0.2.0";
  return report;
}

std::vector<std::string> hostile_names() {
  std::string all_bytes;
  for (int c = 1; c < 256; ++c) all_bytes += static_cast<char>(c);
  return {"a|b",
          "a\\|b",
          "``` `x` ````",
          "</testcase><failure/>]]>&amp;<![CDATA[",
          "<script>alert(1)</script><img src=x onerror=alert(1)>",
          "[click](javascript:alert(1)) ![x](http://example.com/x.png) {0} {{1}}",
          "@octocat #12 !3 ~label %1 $4 http://example.com www.example.com a@example.com",
          "**bold** _it_ ~~gone~~ $x$ - [ ] :smile: &copy; &#64;",
          "line\nbreak\r\n| cell |\n# title\n\ttab",
          std::string("nul\0byte", 8),
          "\x1b[31mred\x1b[0m\x07",
          "\xff\xfe not UTF-8 \xc0\xaf \xed\xa0\x80 \xf4\x90\x80\x80 \xe2\x82",
          "\xef\xbf\xbe\xef\xbf\xbf noncharacters \xf0\x9f\xbf\xbf",
          "\xe2\x80\xaegnp.exe \xe2\x81\xa6 \xe2\x80\x8b\xef\xbb\xbf",
          "   ",
          "- 1. # > = +",
          "Größe Ω 部品 🔩",
          std::string(5000, 'x') + "\xe2\x82\xac",
          all_bytes};
}

Report hostile() {
  std::vector<GateOutcome> outcomes;
  using Make = GateOutcome (*)(const std::string&);
  for (const std::string& name : hostile_names()) {
    for (const Make make : {Make{passed}, Make{failed}, Make{undecided}, Make{broken}}) {
      GateOutcome outcome = make(name);
      if (outcome.measured) outcome.measured->notes = {name};
      outcome.gate.manifest = name;
      if (outcome.measured) change(*outcome.measured, [&](Criterion& c) { c.status = name; });
      outcomes.push_back(std::move(outcome));
    }
  }
  return report_of(std::move(outcomes));
}

Report ordinary() {
  GateOutcome warned = failed("lod-2");
  warned.gate.warn_only = true;
  set_share_of_diagonal(warned.gate, 0.005);
  return report_of({passed("bracket"), failed("lid"), undecided("hinge"), broken("screw"), warned});
}

std::vector<Named> all() {
  GateOutcome stopped = undecided("stopped");
  stopped.measured.reset();
  stopped.interrupted = true;
  Report interrupted = report_of({passed("bracket"), stopped});
  interrupted.interrupted = true;
  Report allowed = report_of({undecided("hinge")});
  allowed.undecided = Undecided::warn;
  GateOutcome by_flags = failed("/parts/a b.stl");
  by_flags.gate.candidate = "/parts/a b.stl";
  by_flags.gate.manifest.clear();
  by_flags.gate.line = 0;
  GateOutcome unbounded = undecided("unbounded");
  change(*unbounded.measured, [](Criterion& c) { c.upper = std::numeric_limits<double>::infinity(); });
  unbounded.measured->witness.reset();
  const Report areas = report_of({area("lid"), area("pin", 0.02), zone("nut")});
  return {{"areas", areas},
          {"ordinary", ordinary()},
          {"hostile", hostile()},
          {"empty", report_of({})},
          {"passed", report_of({passed("bracket"), passed("lid")})},
          {"interrupted", interrupted},
          {"allowed", allowed},
          {"flags", report_of({by_flags})},
          {"unbounded", report_of({unbounded})}};
}

}  // namespace meshgauge::check::samples
