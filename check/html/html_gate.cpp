#include "check/html/html_gate.h"

#include <algorithm>
#include <cstdint>
#include <vector>

#include "api/base/figures.h"
#include "check/html/diagrams.h"
#include "check/html/markup.h"
#include "check/reports/wording.h"
#include "check/text.h"

namespace meshgauge::check {
namespace {

using api::with_unit;

// Difference to the limit, rounded towards what the interval proves.
std::string margin(const Criterion& criterion) {
  if (!(criterion.limit > 0)) return "";
  if (criterion.verdict == api::Verdict::pass) {
    return "at most " + to_digits_above(100 * criterion.upper / criterion.limit, 3) + " % of the limit";
  }
  const double times = criterion.lower / criterion.limit;
  if (criterion.verdict != api::Verdict::fail) return "";
  return times < 2 ? "at least " + to_digits_below(100 * (times - 1), 2) + " % above the limit"
                   : "at least " + to_digits_below(times, 3) + " times the limit";
}

std::string badge(const GateOutcome& outcome, Undecided rule) {
  const Verdict verdict = outcome.verdict();
  const bool warns = outcome.level(rule) == Level::warning;
  return "<span class=\"badge " + std::string(to_string(verdict)) + "\">" + icon(verdict) +
         std::string(to_string(verdict)) + (warns ? ", only warns" : "") + "</span>";
}

std::string place(const Vec3& p) {
  return to_digits(p.x(), 9) + ", " + to_digits(p.y(), 9) + ", " + to_digits(p.z(), 9);
}

std::string witness_list(const GateOutcome& outcome) {
  const auto& witness = outcome.measured->witness;
  if (!witness) return "";
  std::string out = "<dl class=\"witness\"><div><dt>Witness, on the " + witness->from_mesh() + "</dt><dd><code>" +
                    with_unit(place(witness->from), outcome.unit()) + "</code> <span class=\"muted\">" +
                    outcome.measured->place_of_witness() + "</span></dd></div>";
  return out + "<div><dt>Nearest to it, on the " + witness->to_mesh() + "</dt><dd><code>" +
         with_unit(place(witness->to), outcome.unit()) + "</code> <span class=\"muted\">triangle " +
         std::to_string(witness->to_triangle) + "</span></dd></div></dl>\n";
}

std::string direction_of(Direction direction) {
  if (direction == Direction::a_to_b) return "from the candidate to the baseline";
  return direction == Direction::b_to_a ? "from the baseline to the candidate" : "in both directions";
}

std::string alternative(const Surface& surface, bool close) {
  const std::string which = surface.candidate ? "candidate" : "baseline";
  std::string text = (close ? "Close-up of the witness on the " : "The ") + which +
                     ", coloured by its distance to the " + (surface.candidate ? "baseline" : "candidate") + ".";
  if (!close && surface.whole.from) text += " Cross hairs mark the witness.";
  return text;
}

std::string figure(const Surface& surface, const Shot& shot, bool close, const std::string& units) {
  const std::string width = std::to_string(shot.camera.width), height = std::to_string(shot.camera.height);
  std::string out = "<figure class=\"shot\"><div class=\"stage\"><img src=\"data:image/png;base64," + base64(shot.png) +
                    "\" width=\"" + width + "\" height=\"" + height + "\" alt=\"" + alternative(surface, close) +
                    "\">" + overlay(shot, units) + "</div><figcaption>";
  out += close ? "Close-up of the witness" : shot.from ? "Cross hairs: the witness" : "The whole part";
  if (shot.cut) out += ", the part cut open just before it";
  if (!close && shot.hidden) out += ", inside of the part";
  if (!close && shot.close_up > 0) out += "; dashed: the close-up";
  return out + "</figcaption></figure>\n";
}

// "; 3 % above the limit". That of one side is shown on both; it is none of the baseline's points.
std::string above_limit(const Surface& surface, const GateOutcome& outcome) {
  const api::DistanceLimit limit = outcome.measured->shown();
  const std::string share = "; " + to_digits(100 * surface.histogram.above_limit, 3) + " % ";
  if (limit.side.empty()) return share + "above the limit";
  if (!surface.candidate) return "";
  return share + "farther than the limit " + limit.side + ", " +
         escaped(with_unit(to_digits(limit.limit, 6), outcome.unit())) + ", on either side";
}

std::string histogram_part(const Surface& surface, const GateOutcome& outcome) {
  const Histogram& histogram = surface.histogram;
  if (histogram.points == 0) return "";
  const std::string which = surface.candidate ? "candidate" : "baseline", units = outcome.unit();
  const auto figure_of = [&](double x) { return to_digits(x, 3) + (units.empty() ? "" : " " + units); };
  std::string out = "<figure class=\"histogram-figure\">" + histogram_drawing(histogram, surface.scale.top, units);
  out += std::string("<figcaption>Distances ") + (histogram.of_cloud ? "of the " : "over the ") + which +
         "\xE2\x80\x99s " + (histogram.of_cloud ? "points: " : "surface: ") +
         escaped("median " + figure_of(histogram.median) + ", 95 % within " + figure_of(histogram.p95)) +
         above_limit(surface, outcome) +
         (histogram.of_cloud && histogram.all_points ? ". Computed at all " : ". Estimated at ") +
         grouped(histogram.points) + (histogram.of_cloud ? " points" : " points of equal area") + ", not certified; " +
         (histogram.axis.logarithmic ? "both axes are" : "heights are") + " logarithmic.</figcaption></figure>\n";
  return out;
}

std::string surface_part(const Surface& surface, const GateOutcome& outcome) {
  const std::string units = outcome.unit();
  std::string out = "<section class=\"surface" + std::string(surface.close_up ? "" : " small") + "\"><h3>" +
                    std::string(surface.candidate ? "Candidate" : "Baseline") + ", coloured by distance to the " +
                    (surface.candidate ? "baseline" : "candidate") + "</h3>\n";
  out += "<div class=\"shots\">";
  out += figure(surface, surface.whole, false, units);
  if (surface.close_up) out += figure(surface, *surface.close_up, true, units);
  out += "</div>\n<div class=\"scale\">" + colour_bar(surface.scale, units) + histogram_part(surface, outcome);
  return out + "</div></section>\n";
}

std::string pictures_part(const GatePicture* picture, const GateOutcome& outcome) {
  if (!picture) return "";
  if (!picture->missing.empty()) {
    return "<p class=\"note\">No picture: " + escaped(picture->missing) + ".</p>\n";
  }
  std::string out = picture->surfaces.size() > 1 ? "<div class=\"surfaces\">" : "<div class=\"surfaces one\">";
  for (const Surface& surface : picture->surfaces) out += surface_part(surface, outcome);
  return out + "</div>\n";
}

// Facts about the meshes and the work, from a comparison's JSON, as tables. Members that a service leaves out are
// left out.

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

// Empty if the gate expects nothing.
std::string expectation_table(const GateOutcome& outcome) {
  std::string rows;
  for (const Criterion& one : outcome.expectations) {
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

// Directions that ended before the time or the memory was used up are kept.
std::string what_is_missing(const std::string& status) {
  if (status.empty() || status == "complete") return "";
  const std::string why = status == "timeout"     ? "the time was over"
                          : status == "cancelled" ? "the run was interrupted"
                          : status == "memory"    ? "there was not enough memory"
                                                  : status;
  return "<p class=\"note\">Not all statistics that were asked for are there: " + escaped(why) + ".</p>\n";
}

// Empty if no statistics were requested.
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

std::string facts_part(const GateOutcome& outcome) {
  const Measured& measured = *outcome.measured;
  std::string out = "<details><summary>Meshes, times, work</summary>\n" + mesh_table(outcome);
  out += statistics_table(measured) + work_table(outcome) + time_table(measured);
  return out + "</details>\n";
}

std::string subtitle(const GateOutcome& outcome) {
  std::string out = "<p class=\"files\">";
  if (const std::string candidate = outcome.gate.candidate.string(); !candidate.empty())
    out += "<span>" + escaped(candidate) + "</span> <span class=\"muted\">against</span> ";
  out += "<span>" + escaped(outcome.gate.baseline.string()) + "</span>";
  if (!outcome.gate.manifest.empty()) {
    out += " <span class=\"muted\">" + escaped(outcome.gate.manifest) + ":" + std::to_string(outcome.gate.line) +
           "</span>";
  }
  return out + "</p>\n";
}

std::string advice_part(const GateOutcome& outcome) {
  const std::string advice = outcome.advice();
  if (advice.empty() || !outcome.measured) return "";
  return "<p class=\"advice\"><strong>What to do.</strong> " + escaped(advice) + "</p>\n";
}

std::string notes_part(const GateOutcome& outcome) {
  std::string out;
  for (const std::string& note : notes_of(outcome)) out += "<p class=\"note\">Note: " + escaped(note) + ".</p>\n";
  return out;
}

std::string link_part(const Measured& measured) {
  if (measured.link.empty()) return "";
  return "<p class=\"link\"><a href=\"" + escaped(measured.link) +
         "\" rel=\"noreferrer\">See the difference</a> <span class=\"muted\">at the service, as long as it keeps the "
         "result</span></p>\n";
}

// "Not as expected: watertight, volume. "; empty: all is, or undecided.
std::string surprises(const GateOutcome& outcome) {
  std::string names;
  for (const Criterion& one : outcome.expectations) {
    if (one.verdict == api::Verdict::fail) names += (names.empty() ? "" : ", ") + one.name;
  }
  return names.empty() ? "" : "Not as expected: " + names + ". ";
}

std::string measured_part(const GateOutcome& outcome, const GatePicture* picture) {
  const Measured& measured = *outcome.measured;
  std::string out = expectation_table(outcome);
  for (const Criterion& criterion : measured.criteria) out += interval_drawing(criterion, outcome.unit()) + "\n";
  for (const Chart& chart : charts_of(outcome)) out += history_drawing(chart);
  out += notes_part(outcome);
  if (picture && picture->left_out) return out + advice_part(outcome) + link_part(measured);
  out += advice_part(outcome) + link_part(measured) + witness_list(outcome) + pictures_part(picture, outcome);
  return out + facts_part(outcome);
}

// Returns "within the limit of 0.05 mm: the distance is at most 0.04 mm, at most 80 % of the limit." or the like.
std::string sentence_of(const GateOutcome& outcome, const Criterion& criterion, const std::string& limit) {
  const IntervalText text = figures_of(criterion);
  const std::string unit = criterion.beyond ? "%" : outcome.unit(), by = margin(criterion);
  const std::string end = (by.empty() ? "" : ", " + by) + ". ";
  const bool is_pass = criterion.verdict == api::Verdict::pass;
  if (!criterion.refused.empty())
    return "Not decided: nothing is inside or outside of the baseline. " + criterion.refused + ". ";
  if (criterion.verdict == api::Verdict::undecided) {
    const std::string of = criterion.beyond ? "share of the area farther than " +
                                                  with_unit(to_digits(*criterion.beyond, 6), outcome.unit())
                                            : criterion.name;
    if (criterion.is_uncertain())
      return "Not decided: the limit is " + limit + ", the " + of + " lies between " + text.lower + " and " +
             with_unit(text.upper, unit) + ". ";
    return "Not decided: the limit of " + limit + " lies between the bounds of the " + of + ", " + text.lower +
           " and " + with_unit(text.upper, unit) + ". ";
  }
  const std::string found = criterion.beyond ? api::share_in_words(criterion, outcome.unit())
                                             : "the " + criterion.name + " is at " + (is_pass ? "most " : "least ") +
                                                   with_unit(is_pass ? text.upper : text.lower, unit);
  return (is_pass ? "Certainly within the limit of " : "Certainly beyond the limit of ") + limit + ": " + found + end;
}

// The limit of a distance, first as the manifest says it.
std::string length_text(const GateOutcome& outcome, const Criterion& criterion) {
  const std::string share = share_of_diagonal(outcome, criterion), more = plus_minus(criterion, outcome.unit());
  if (share.empty()) return with_unit(to_digits(criterion.limit, 12), outcome.unit()) + more;
  return share + " of the diagonal (" + with_unit(figures_of(criterion).limit, outcome.unit()) + ")" + more;
}

}  // namespace

std::string gate_id(std::size_t index) { return "gate-" + std::to_string(index + 1); }

std::string sentence(const GateOutcome& outcome) {
  if (!outcome.measured) {
    const std::string why = outcome.error ? outcome.advice() : "";
    return why.empty() ? "Interrupted before anything was known." : why;
  }
  std::string text, last;
  for (const Criterion& criterion : outcome.measured->criteria) {
    const std::string limit = criterion.beyond ? figures_of(criterion).limit + " %" : length_text(outcome, criterion);
    std::string one = sentence_of(outcome, criterion, limit);
    if (one != last) text += one;
    last = std::move(one);
  }
  return text + "Measured " + direction_of(outcome.gate.request.options.direction) + ".";
}

std::string gate_card(const GateOutcome& outcome, const GatePicture* picture, std::size_t index, Undecided rule) {
  const std::string id = gate_id(index), kind(to_string(outcome.verdict()));
  std::string out =
      "<article class=\"gate " + kind + "\" id=\"" + id + "\" aria-labelledby=\"" + id + "-name\">\n<header>";
  out += badge(outcome, rule) + "<h2 id=\"" + id + "-name\">" + escaped(outcome.gate.name) + "</h2>" +
         "<span class=\"time\">" + in_time(outcome.wall_ms) + "</span></header>\n";
  out += subtitle(outcome) + "<p class=\"sentence\">" + escaped(surprises(outcome) + sentence(outcome)) + "</p>\n";
  out += outcome.measured ? measured_part(outcome, picture) : notes_part(outcome);
  return out + "</article>\n";
}

}  // namespace meshgauge::check
