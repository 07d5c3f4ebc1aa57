#include <doctest/doctest.h>

#include <limits>
#include <string>

#include "check/outcome.h"
#include "check/run/gates.h"

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

GateOutcome with(const Measured& measured) {
  GateOutcome outcome;
  outcome.gate = gate("part.stl", "cad.stl", measured.criteria.front().limit);
  outcome.gate.request.options.units.limit = LengthUnit::millimeter;
  outcome.measured = measured;
  return outcome;
}

GateOutcome with(const Error& error) {
  GateOutcome outcome;
  outcome.gate = gate("part.stl", "cad.stl", 1);
  outcome.error = error;
  return outcome;
}

}  // namespace

TEST_CASE("a gate that passes has no advice") { CHECK(with(measured(0, 1, 2)).advice().empty()); }

TEST_CASE("undecided: the limits and the time that would decide") {
  CHECK(with(measured(0.25, 0.75, 0.5, "timeout")).advice() ==
        "Decided by a limit of at least 0.75 mm (pass) or below 0.25 mm (fail); or a longer timeout than 30 s.");
  CHECK(with(measured(0, 0.75, 0.5, "cancelled")).advice() ==
        "Decided by a limit of at least 0.75 mm (pass); or letting it run to its end.");
  CHECK(with(measured(0.25, 0.75, 0.5, "converged")).advice().find("a smaller tolerance") != std::string::npos);
  CHECK(with(measured(0.25, 0.75, 0.5, "budget")).advice().find("memory") != std::string::npos);
  CHECK(with(measured(0.25, 0.75, 0.5, "precision_floor")).advice().find("rounding") != std::string::npos);
}

TEST_CASE("undecided: the shares of the area that would decide") {
  GateOutcome outcome = with(measured(0.25, 0.75, 0.5));
  Measured& found = *outcome.measured;
  const auto ended = [&](const char* status) { set_criteria(found, {share(0.5, 0.25, 0, 0.5, status)}); };
  ended("timeout");
  CHECK(outcome.advice().starts_with("Decided by a share of at least 50"));
  CHECK(outcome.advice().ends_with(" % (pass); or a longer timeout than 30 s."));
  ended("precision_floor");
  CHECK(outcome.advice() ==
        "Decided by another distance than 0.5 mm: part of the area is that far away, within rounding error.");
  ended("no_area");
  CHECK(outcome.advice() == "A mesh has no area: all its triangles are degenerate.");
}

TEST_CASE("undecided: impossible advice is left out") {
  GateOutcome outcome = with(measured(0.25, 0.75, 0.5, "timeout"));
  outcome.gate.request.timeout = std::chrono::seconds(180);
  CHECK(outcome.advice().find("longer timeout") == std::string::npos);
  CHECK(outcome.advice().find("(fail); or more threads") != std::string::npos);
  change(*outcome.measured, [](Criterion& c) { c.upper = std::numeric_limits<double>::infinity(); });
  CHECK(outcome.advice().find("Decided by a limit below 0.25 mm (fail); or more threads") == 0);
  change(*outcome.measured, [](Criterion& c) { c.lower = 0; });
  outcome.gate.request.timeout = std::chrono::seconds(1);
  CHECK(outcome.advice() == "Decided by a longer timeout than 1 s.");
}

TEST_CASE("undecided without an interval: by Ctrl-C, or by the timeout") {
  GateOutcome outcome;
  outcome.gate = gate("part.stl", "cad.stl", 1);
  outcome.gate.request.timeout = std::chrono::milliseconds(1500);
  outcome.interrupted = true;
  CHECK(outcome.advice() == "Interrupted before anything was known: run it again.");
  outcome.error = Error{ErrorCode::out_of_time, "timed out before 'part.stl' was read", "a", ""};
  CHECK(outcome.advice() == "timed out before 'part.stl' was read: decided by a longer timeout than 1.5 s.");
}

TEST_CASE("fail: where to look, and on which of the two") {
  Measured failed = measured(0.75, 0.8, 0.5);
  failed.witness = check::Witness{true, Vec3(1, 2.5, -3), 17, Vec3(1, 2.5, -2.25), 4};
  CHECK(with(failed).advice() ==
        "Look at (1, 2.5, -3) mm on triangle 17 of the candidate: it is 0.75 mm or more from the baseline, nearest to "
        "(1, 2.5, -2.25) mm on triangle 4.");
  failed.witness->on_candidate = false;
  const std::string hole = with(failed).advice();
  CHECK(hole.find("triangle 17 of the baseline: it is 0.75 mm or more from the candidate") != std::string::npos);
  CHECK(hole.find("The candidate lacks what the baseline has there") != std::string::npos);
}

TEST_CASE("error: what is wrong, and what to repair") {
  CHECK(with(Error{ErrorCode::unsupported_format, "unknown", "b", ""}).advice() ==
        "unknown. Export 'cad.stl' as OBJ, STL, PLY, OFF, glTF, GLB or 3MF.");
  for (const auto code : {ErrorCode::unreadable_mesh, ErrorCode::non_finite_vertex, ErrorCode::index_out_of_range}) {
    CHECK(with(Error{code, "bad", "a", ""}).advice() ==
          "bad. Write 'part.stl' again: it is damaged, or its writer does not follow the format.");
  }
  CHECK(with(Error{ErrorCode::unreadable_mesh, "it has '..'", "a", "buffers[0].uri"}).advice() ==
        "it has '..'. Export 'part.stl' as one .glb.");
  CHECK(with(Error{ErrorCode::empty_mesh, "empty", "a", ""}).advice() ==
        "empty. Check the step that writes 'part.stl'.");
  CHECK(with(Error{ErrorCode::too_large, "large", "a", ""}).advice().find("smaller") != std::string::npos);
  CHECK(with(Error{ErrorCode::unsupported_format, "'b' is a Git LFS pointer, not a mesh: x", "b", ""}).advice() ==
        "'b' is a Git LFS pointer, not a mesh: x. Check the repository out with Git LFS ('lfs: true' of "
        "actions/checkout).");
  CHECK(with(Error{ErrorCode::unsupported_format, "'a' is a web page (HTML), not a mesh", "a", ""}).advice() ==
        "'a' is a web page (HTML), not a mesh. Check the step that puts 'part.stl' there.");
  CHECK(with(Error{ErrorCode::invalid_request, "'part.stl' cannot be read: gone", "a", ""}).advice() ==
        "'part.stl' cannot be read: gone. Check its path, its permissions and the step that writes it.");
  CHECK(with(Error{ErrorCode::internal, "the service is gone", "", ""}).advice() == "the service is gone");
}
