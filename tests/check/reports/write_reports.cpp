// Writes what schemas and other programs are to read: write_reports FOLDER.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <utility>

#include "check/reports/reports.h"
#include "check/reports/sample_reports.h"
#include "server/handlers/batch_report.h"

namespace {

bool write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  return static_cast<bool>(out << text << std::flush);
}

// A service's report, with a comparison of every kind, and names that hold anything.
std::string batch_report() {
  namespace store = meshgauge::server::store;
  store::Batch batch;
  batch.name = "<&>\"' ]]> \xC3\xA9 \xEF\xBF\xBF.stl";
  batch.counts = {7, 0, 0, 4, 1, 1, 1, 1, 1, 1};
  std::string text = meshgauge::server::junit_head(batch);
  std::uint64_t position = 0;
  const auto add = [&](std::optional<store::Job> job) {
    text += meshgauge::server::junit_case(batch, {position++, batch.name, std::move(job)});
  };
  for (const char* verdict : {"", "pass", "fail", "undecided"}) {
    store::Job job;
    job.state = store::JobState::done;
    job.verdict = verdict;
    job.options = R"({"gate":{"max_distance":0.25,"units":"<mm>"}})";
    job.document = R"({"distance":{"lower":0.5,"upper":0.75}})";
    add(job);
  }
  for (const auto state : {store::JobState::failed, store::JobState::cancelled}) {
    store::Job job;
    job.state = state;
    add(job);
  }
  add(std::nullopt);
  return text + meshgauge::server::junit_tail();
}

// The report as a comment that tells changes from a run of gates with names that hold anything.
std::string comment_of(meshgauge::check::Report report) {
  using namespace meshgauge::check;
  Earlier earlier{"`main|"};
  for (const std::string& name : samples::hostile_names()) earlier.gates["was " + name] = EarlierGate{Verdict::pass};
  report.since = std::move(earlier);
  return to_comment(report, kMarkdownBytes);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: write_reports FOLDER\n"), 3;
  const std::filesystem::path folder = argv[1];
  bool ok = write(folder / "batch.xml", batch_report());
  for (const auto& [name, report] : meshgauge::check::samples::all()) {
    ok = ok && write(folder / (std::string(name) + ".xml"), to_junit(report));
    ok = ok && write(folder / (std::string(name) + ".sarif"), to_sarif(report));
    ok = ok && write(folder / (std::string(name) + ".md"), to_markdown(report));
    ok = ok && write(folder / (std::string(name) + ".comment.md"), comment_of(report));
    ok = ok && write(folder / (std::string(name) + ".codequality.json"), to_code_quality(report));
  }
  return ok ? 0 : 3;
}
