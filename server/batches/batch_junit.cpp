#include "server/batches/batch_junit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <chrono>
#include <sstream>

#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "server/batches/batch_document.h"
#include "server/jobs/job_document.h"

namespace meshgauge::server {
namespace {

void set(pugi::xml_node node, const char* name, const std::string& value) {
  node.append_attribute(name).set_value(value.c_str());
}

std::string printed(const pugi::xml_document& document, const char* indent) {
  std::ostringstream out;
  for (const pugi::xml_node node : document.children()) node.print(out, "  ", pugi::format_indent, pugi::encoding_utf8);
  std::string text = out.str();
  std::string shifted;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    shifted.append(indent).append(text, at, end - at).append("\n");
    at = end == std::string::npos ? text.size() : end + 1;
  }
  return shifted;
}

std::string shortest(double value) {
  std::array<char, 64> text{};
  return {text.data(), std::to_chars(text.begin(), text.end(), value).ptr};
}

std::string to_text(double seconds) {
  std::array<char, 64> text{};
  return {text.data(),
          std::to_chars(text.begin(), text.end(), std::max(0.0, seconds), std::chars_format::fixed, 3).ptr};
}

std::string seconds_between(store::TimePoint from, store::TimePoint to) {
  return to_text(std::chrono::duration<double>(to - from).count());
}

// Of the measurement. The store's own times count what a job waits for in its worker's stock.
std::string seconds_of_work(const store::Job& job) {
  const auto document = nlohmann::json::parse(job.document, nullptr, false);
  const auto times = document.is_object() ? document.find("timings_ms") : document.end();
  if (times == document.end() || !times->is_object()) {
    return job.started && job.finished ? seconds_between(*job.started, *job.finished) : "0.000";
  }
  return to_text((times->value("total", 0.0) - times->value("queue", 0.0)) / 1000);
}

// XML has no control characters and neither U+FFFE nor U+FFFF, however they are written.
std::string shown(std::string text) {
  for (char& c : text) {
    if ((static_cast<unsigned char>(c) < 0x20 && c != '\n') || c == 0x7F) c = '?';
  }
  for (const char* code : {"\xEF\xBF\xBE", "\xEF\xBF\xBF"}) {
    for (std::size_t at = text.find(code); at != std::string::npos; at = text.find(code)) text.replace(at, 3, "?");
  }
  return text;
}

std::string name_of(const store::Batch& batch) { return batch.name.empty() ? batch.key.id : shown(batch.name); }

// Viewers make a package of what stands before the last dot.
std::string class_name(const store::Batch& batch) {
  std::string name = name_of(batch);
  std::replace(name.begin(), name.end(), '.', '_');
  return "meshgauge." + name;
}

std::string detail_of(const store::Job& job) {
  const auto problem = nlohmann::json::parse(problem_json(job), nullptr, false);
  return problem.is_object() ? problem.value("detail", std::string("it failed")) : "it failed";
}

std::string found(const store::Job& job) {
  const auto distance = distance_of(job);
  if (!distance) return detail_of(job);
  const std::string units = unit_of(job).empty() ? "" : " " + unit_of(job);
  std::string text = "distance in [" + shortest(distance->lower) + ", " + shortest(distance->upper) + "]" + units;
  if (const auto limit = limit_of(job)) text += ", limit " + shortest(*limit) + units;
  return text;
}

struct Defect {
  const char* element;
  std::string type;
  std::string message;
};

std::optional<Defect> defect_of(const store::BatchRow& row) {
  if (!row.job) return Defect{"error", "gone", "its result is not kept any more"};
  const store::Job& job = *row.job;
  if (job.state != store::JobState::done) return Defect{"error", to_string(job.state), found(job)};
  if (job.verdict.empty() || job.verdict == "pass") return std::nullopt;
  return Defect{"failure", job.verdict, found(job)};
}

}  // namespace

std::string junit_head(const store::Batch& batch) {
  const store::BatchCounts& counts = batch.counts;
  pugi::xml_document document;
  pugi::xml_node suite = document.append_child("testsuite");
  set(suite, "name", name_of(batch));
  set(suite, "package", class_name(batch));
  set(suite, "id", "0");
  set(suite, "timestamp", to_text(batch.created).substr(0, 19));  // the schema knows no time zones: this is UTC
  set(suite, "hostname", "localhost");                            // required, and nobody's business
  set(suite, "tests", std::to_string(counts.total));
  set(suite, "failures", std::to_string(counts.fail + counts.undecided));
  set(suite, "errors", std::to_string(counts.failed + counts.cancelled + counts.gone));
  set(suite, "time", seconds_between(batch.created, batch.finished.value_or(batch.created)));
  pugi::xml_node property = suite.append_child("properties").append_child("property");
  set(property, "name", "batch");
  set(property, "value", "/v1/batches/" + batch.key.id);
  std::string text = printed(document, "  ");
  text.resize(text.rfind("  </testsuite>"));
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites>\n" + text;
}

std::string junit_case(const store::Batch& batch, const store::BatchRow& row) {
  pugi::xml_document document;
  pugi::xml_node test = document.append_child("testcase");
  set(test, "name", row.name.empty() ? "comparison " + std::to_string(row.position) : shown(row.name));
  set(test, "classname", class_name(batch));
  set(test, "time", row.job ? seconds_of_work(*row.job) : "0.000");
  if (const auto defect = defect_of(row)) {
    pugi::xml_node node = test.append_child(defect->element);
    set(node, "message", shown(defect->message));
    set(node, "type", defect->type);
    const std::string where = row.job ? "\ncomparison: /v1/comparisons/" + row.job->key.id : "";
    node.append_child(pugi::node_pcdata).set_value(shown(defect->message + where).c_str());
  }
  return printed(document, "    ");
}

std::string junit_tail() { return "    <system-out/>\n    <system-err/>\n  </testsuite>\n</testsuites>\n"; }

}  // namespace meshgauge::server
