#include "check/html/html_facts.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "check/html/diagrams.h"
#include "check/html/markup.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using Json = nlohmann::ordered_json;

// Null if a member on the path is missing.
const Json& at(const Json& json, const std::string& path) {
  static const Json kNull;
  const Json::json_pointer pointer(path);
  return json.contains(pointer) ? json.at(pointer) : kNull;
}

std::string number(const Json& json, int digits = 6) {
  return json.is_number() ? to_digits(json.get<double>(), digits) : "";
}

std::string count(const Json& json) { return json.is_number_unsigned() ? grouped(json.get<std::uint64_t>()) : ""; }

std::string words(const Json& json) { return json.is_string() ? json.get<std::string>() : ""; }

std::string row(const std::string& name, const std::vector<std::string>& cells) {
  const bool empty = std::all_of(cells.begin(), cells.end(), [](const std::string& cell) { return cell.empty(); });
  if (empty) return "";
  std::string out = "<tr><th scope=\"row\">" + escaped(name) + "</th>";
  for (const std::string& cell : cells) out += "<td>" + escaped(cell) + "</td>";
  return out + "</tr>\n";
}

std::string table(const std::string& css_class, const std::string& caption, const std::vector<std::string>& columns,
                  const std::string& rows) {
  if (rows.empty()) return "";
  std::string out =
      "<div class=\"scroll\"><table class=\"" + css_class + "\"><caption>" + escaped(caption) + "</caption>";
  out += "<thead><tr>";
  for (const std::string& column : columns) out += "<th scope=\"col\">" + escaped(column) + "</th>";
  return out + "</tr></thead><tbody>\n" + rows + "</tbody></table></div>\n";
}

std::string extent(const Json& mesh) {
  std::string text;
  for (const char* axis : {"0", "1", "2"}) {
    const Json& low = at(mesh, std::string("/bbox/low/") + axis);
    const Json& high = at(mesh, std::string("/bbox/high/") + axis);
    if (!low.is_number() || !high.is_number()) return "";
    text += (text.empty() ? "" : " \xC3\x97 ") + to_digits(high.get<double>() - low.get<double>(), 5);
  }
  return text;
}

std::string triangles(const Json& mesh) {
  const std::string all = count(at(mesh, "/triangles")), degenerate = count(at(mesh, "/degenerate"));
  if (all == "0") return "none, a point cloud";
  return all.empty() || degenerate.empty() || degenerate == "0" ? all : all + " (" + degenerate + " degenerate)";
}

std::string bytes(const Json& mesh) {
  const Json& size = at(mesh, "/bytes");
  return size.is_number_unsigned() ? in_bytes(size.get<std::uint64_t>()) : "";
}

std::string notes(const Json& mesh) {
  std::string all;
  const Json& list = at(mesh, "/notes");
  for (const Json& note : list) all += (all.empty() ? "" : " ") + words(note);
  return all;
}

// A row with one cell for each mesh.
template <class Cell>
std::vector<std::string> both(const Json& document, const Cell& cell) {
  return {cell(at(document, "/meshes/a")), cell(at(document, "/meshes/b"))};
}

std::string interval(const Json& directed) {
  const Json& lower = at(directed, "/lower");
  const Json& upper = at(directed, "/upper");
  if (!lower.is_number()) return "";
  const std::string high = upper.is_number() ? to_digits_above(upper.get<double>(), 6) : "unknown";
  return to_digits_below(lower.get<double>(), 6) + " \xE2\x80\xA6 " + high;
}

std::string culled(const Json& directed) {
  const Json& rate = at(directed, "/culling/rate");
  return rate.is_number() ? to_digits(100 * rate.get<double>(), 4) + " %" : "";
}

std::string estimate(const Json& json) {
  const std::string value = number(at(json, "/value"), 5), error = number(at(json, "/standard_error"), 2);
  return value.empty() || error.empty() ? value : value + " \xC2\xB1 " + error;
}

}  // namespace

std::string expectation_table(const GateOutcome& outcome) {
  std::string rows;
  for (const Expectation& one : outcome.expectations) {
    const std::string kind(to_string(one.verdict));
    rows += "<tr><th scope=\"row\">" + escaped(one.name) + "</th><td>" + escaped(one.found) + "</td><td>" +
            escaped(one.expected) + "</td><td><span class=\"badge " + kind + "\">" + icon(verdict_of(one.verdict)) +
            kind + "</span></td></tr>\n";
  }
  return table("expectations", "What the gate expects of the candidate", {"", "Found", "Expected", "Verdict"}, rows);
}

std::string mesh_table(const GateOutcome& outcome) {
  const Json& document = outcome.measured->document;
  std::string rows = row("File", {outcome.gate.candidate.string(), outcome.gate.baseline.string()});
  rows += row("Format", both(document, [](const Json& m) { return words(at(m, "/format")); }));
  rows += row("Triangles", both(document, triangles));
  rows += row("Vertices", both(document, [](const Json& m) { return count(at(m, "/vertices")); }));
  rows += row("Size", both(document, extent));
  rows += row("Diagonal", both(document, [](const Json& m) { return number(at(m, "/diagonal")); }));
  rows += row("Bytes", both(document, bytes));
  rows += row("SHA-256", both(document, [](const Json& m) { return words(at(m, "/sha256")); }));
  rows += row("Notes", both(document, notes));
  return table("meshes", "Meshes", {"", "Candidate", "Baseline"}, rows);
}

std::string time_table(const Measured& measured) {
  const Json& times = at(measured.document, "/timings_ms");
  const Json& total = at(times, "/total");
  if (!total.is_number()) return "";
  std::string rows;
  for (const auto& [stage, ms] : times.items()) {
    if (!ms.is_number() || (ms.get<double>() == 0 && stage != "total")) continue;
    std::string name = stage == "read_a" ? "read candidate" : stage == "read_b" ? "read baseline" : stage;
    std::replace(name.begin(), name.end(), '_', ' ');
    const double share = total.get<double>() > 0 ? ms.get<double>() / total.get<double>() : 0;
    rows += "<tr><th scope=\"row\">" + escaped(name) + "</th><td>" + in_time(ms.get<double>()) +
            "</td><td class=\"wide\">" + share_bar(share) + "</td></tr>\n";
  }
  return table("times", "Time by stage", {"Stage", "Time", "Share of the whole"}, rows);
}

std::string work_table(const GateOutcome& outcome) {
  const Json& document = outcome.measured->document;
  const Json& there = at(document, "/a_to_b");
  const Json& back = at(document, "/b_to_a");
  const auto asked = [](const Json& directed, const char* what) { return count(at(at(directed, "/work"), what)); };
  std::string rows = row("Interval", {interval(there), interval(back)});
  rows += row("Culled at once", {culled(there), culled(back)});
  rows += row("Nearest-point queries", {asked(there, "/nearest_queries"), asked(back, "/nearest_queries")});
  rows += row("Triangles subdivided", {asked(there, "/subdivisions"), asked(back, "/subdivisions")});
  return table("work", "By direction", {"", "Candidate to baseline", "Baseline to candidate"}, rows);
}

namespace {

// Directions that ended before the time or the memory was used up are kept.
std::string what_is_missing(const std::string& status) {
  if (status.empty() || status == "complete") return "";
  const std::string why = status == "timeout"     ? "the time was over"
                          : status == "cancelled" ? "the run was interrupted"
                          : status == "memory"    ? "there was not enough memory"
                                                  : status;
  return "<p class=\"note\">Not all statistics that were asked for are there: " + escaped(why) + ".</p>\n";
}

}  // namespace

std::string statistics_table(const Measured& measured) {
  const Json& statistics = at(measured.document, "/statistics");
  std::string rows;
  const auto add = [&](const char* name, const char* path) {
    rows += row(name, {estimate(at(statistics, std::string("/a_to_b") + path)),
                       estimate(at(statistics, std::string("/b_to_a") + path))});
  };
  add("Mean", "/mean");
  add("RMS", "/rms");
  add("Median", "/p50");
  add("95th percentile", "/p95");
  add("99th percentile", "/p99");
  rows += row("Samples", {count(at(statistics, "/a_to_b/samples")), count(at(statistics, "/b_to_a/samples"))});
  return table("work", "Statistics: sampled, with standard errors, not certified",
               {"", "Candidate to baseline", "Baseline to candidate"}, rows) +
         what_is_missing(words(at(statistics, "/status")));
}

}  // namespace meshgauge::check
