#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/base/machine.h"
#include "api/base/refused.h"
#include "api/base/utc.h"
#include "api/options/request.h"
#include "check/html/html.h"
#include "check/manifest/baselines.h"
#include "check/outcome.h"
#include "check/remote.h"
#include "check/reports/earlier.h"
#include "check/reports/history.h"
#include "check/reports/reports.h"
#include "check/reports/wording.h"
#include "check/revision/revision.h"
#include "check/run/json_report.h"
#include "check/run/local.h"
#include "check/run/meshes.h"
#include "check/run/run.h"
#include "check/run/terminal.h"
#include "cli/check_extras.h"
#include "cli/check_flags.h"
#include "cli/check_start.h"
#include "cli/commands.h"
#include "cli/heap.h"
#include "cli/interrupts.h"
#include "cli/pipes.h"
#include "cli/places.h"
#include "engine/result.h"

namespace meshgauge::cli {
namespace {

using check::Report;
using Gates = std::vector<check::Gate>;
using Pictures = std::vector<check::GatePicture>;

// Prints the message on one line, without anything that a terminal or a CI runner would interpret: messages and names
// of files are foreign text.
int fail_on_one_line(const std::string& message) {
  std::fprintf(stderr, "meshgauge: %s\n", check::for_log(check::shown_name(message)).c_str());
  return kExitError;
}

Error unwritable(const std::string& flag, const std::string& where, const std::string& why) {
  const std::string place = where == "-" ? "standard output" : "'" + where + "'";
  return bad_flag(flag, place + " " + why);
}

Error failed(const std::string& flag, const std::string& where) {
  return unwritable(flag, where, std::string("could not be written: ") + std::strerror(errno));
}

struct Closed {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

bool put(const std::string& text, std::FILE* out) {
  return std::fwrite(text.data(), 1, text.size(), out) == text.size() && std::fflush(out) == 0;
}

// `stream`: what "-" is; standard error may be closed.
Result<Done> write_to(const std::string& flag, const std::string& where, std::FILE* stream, const std::string& text) {
  if (where == "-") return put(text, stream) || stream == stderr ? Result<Done>(Done{}) : failed(flag, where);
  const std::unique_ptr<std::FILE, Closed> file(std::fopen(where.c_str(), "we"));
  if (!file || !put(text, file.get())) return failed(flag, where);
  return Done{};
}

Result<Done> has_folder(const std::string& flag, const std::string& where) {
  const std::filesystem::path path(where);
  std::error_code none;
  if (std::filesystem::is_directory(path, none)) return unwritable(flag, where, "is a folder: name a file in it");
  const auto folder = path.has_parent_path() ? path.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, none))
    return unwritable(flag, where, "cannot be written: its folder does not exist");
  if (access(folder.c_str(), W_OK) != 0 && access(where.c_str(), W_OK) != 0) return failed(flag, where);
  return Done{};
}

// Writes the reports that `check` was asked for.
class ReportFiles {
 public:
  using Write = std::function<std::string(const Report&)>;

  // `where`: a file, "-" for `stream`, or empty: not wanted. `flag` names it in messages.
  void add(const std::string& flag, const std::string& where, Write write, std::FILE* stream = stdout) {
    if (!where.empty()) entries_.push_back({flag, where, std::move(write), stream});
  }

  // Checks before measuring and adds all files to `places`. Errors: two reports for standard output, a report over a
  // file of `places`, a folder that does not exist or is not writable.
  Result<Done> possible(Places& places) const {
    const Entry* on_stdout = nullptr;
    for (const Entry& entry : entries_) {
      if (entry.where == "-") {
        if (entry.stream != stdout) continue;
        if (on_stdout)
          return unwritable(entry.flag, entry.where, "is used by " + on_stdout->flag + " already: name a file");
        on_stdout = &entry;
        continue;
      }
      if (auto ok = has_folder(entry.flag, entry.where); !ok) return ok;
      if (auto ok = places.writes(entry.flag, entry.where); !ok) return ok;
    }
    return Done{};
  }

  // Whether nothing else may be printed there.
  bool to_stdout() const {
    return std::any_of(entries_.begin(), entries_.end(), [](const Entry& entry) { return entry.is_on_stdout(); });
  }

  // Writes all reports, also after a failure. Returns the first Error.
  Result<Done> write(const Report& report) const {
    Result<Done> all = Done{};
    for (const Entry& entry : entries_) {
      auto written = write_to(entry.flag, entry.where, entry.stream, entry.write(report));
      if (!written && all) all = std::move(written);
    }
    return all;
  }

 private:
  struct Entry {
    std::string flag, where;
    Write write;
    std::FILE* stream;

    bool is_on_stdout() const { return where == "-" && stream == stdout; }
  };
  std::vector<Entry> entries_;
};

// Borrows `pictures`, which are complete when the reports are written.
ReportFiles reports_of(const CheckFlags& flags, const Pictures& pictures) {
  ReportFiles reports;
  reports.add("--json", flags.json, check::to_json);
  reports.add("--junit", flags.junit, [](const Report& report) { return check::to_junit(report); });
  reports.add("--sarif", flags.sarif, check::to_sarif);
  reports.add("--markdown", flags.markdown, [](const Report& report) { return check::to_markdown(report); });
  reports.add("--comment", flags.comment, [](const Report& report) { return check::to_comment(report); });
  reports.add("--code-quality", flags.code_quality, check::to_code_quality);
  reports.add("--html", flags.html, [&pictures](const Report& report) { return check::to_html(report, pictures); });
  const char* repository = std::getenv("GITHUB_WORKSPACE");
  const std::string top = repository ? repository : "";
  const auto annotations = [top](const Report& report) { return check::to_annotations(report, top); };
  reports.add("--annotations", place_of_annotations(flags), annotations, stderr);
  return reports;
}

Places inputs_of(const CheckFlags& flags, const Gates& gates) {
  Places places;
  if (flags.files.size() == 1) places.reads(flags.files[0], "the manifest");
  if (!flags.key_file.empty()) places.reads(flags.key_file, "the service's key");
  if (!flags.ca_file.empty()) places.reads(flags.ca_file, "the certificates to trust");
  if (!flags.since.empty()) places.reads(flags.since, "the report of an earlier run");
  for (const check::Gate& gate : gates) {
    places.reads(gate.candidate, "the candidate of the gate '" + gate.name + "'");
    places.reads(gate.baseline, "the baseline of the gate '" + gate.name + "'");
  }
  return places;
}

// https://no-color.org: any value but an empty one turns colours off.
bool colours(const CheckFlags& flags, int file) {
  const char* no_color = std::getenv("NO_COLOR");
  return !flags.no_colour && !(no_color && *no_color) && isatty(file) != 0;
}

Result<unsigned> jobs_of(const CheckFlags& flags) {
  const auto jobs = api::in_range(flags.jobs, {0, 1024, true}, "--jobs");
  if (!jobs) return jobs.error();
  return static_cast<unsigned>(*jobs);
}

// Links to the pages of batches at a service. Threads of the measurer add them, another thread prints them.
class Batches {
 public:
  void add(const std::string& link) {
    const std::lock_guard lock(mutex_);
    links_.push_back(link);
  }
  // Returns the links added since the last call.
  std::vector<std::string> fresh() {
    const std::lock_guard lock(mutex_);
    return {links_.begin() + static_cast<std::ptrdiff_t>(std::exchange(taken_, links_.size())), links_.end()};
  }
  std::vector<std::string> all() {
    const std::lock_guard lock(mutex_);
    return links_;
  }

 private:
  std::mutex mutex_;
  std::vector<std::string> links_;
  std::size_t taken_ = 0;
};

Result<std::unique_ptr<check::Measurer>> service_of(const CheckFlags& flags, unsigned jobs, Batches& batches) {
  auto key = check::service_key(flags.key_file);
  if (!key) return key.error();
  check::RemoteOptions options;
  options.url = flags.server;
  options.key = std::move(*key);
  options.key_in_clear = flags.key_in_clear;
  options.ca_file = flags.ca_file;
  if (jobs > 0) options.at_once = jobs;
  options.batch_begun = [&batches](const std::string& link) { batches.add(link); };
  return check::remote(options);
}

// The measurer of a run, and what else is made of its meshes.
struct RunParts {
  std::unique_ptr<Batches> batches;
  std::shared_ptr<check::Meshes> meshes;
  std::unique_ptr<check::Measurer> measurer;
  std::unique_ptr<CheckExtras> extras;
};

Result<Extras> extras_of(const CheckFlags& flags, const Gates& gates, Places& places) {
  auto maps = DeviationMaps::open(flags.deviation, flags.files.size() == 1, gates, places);
  if (!maps) return maps.error();
  auto pictures = PictureFiles::open(flags.pictures, gates, places);
  if (!pictures) return pictures.error();
  return Extras{!flags.html.empty(), *std::move(pictures), *std::move(maps), flags.map_normals};
}

Result<RunParts> parts_of(const CheckFlags& flags, const Gates& gates, Places& places) {
  const auto jobs = jobs_of(flags);
  if (!jobs) return jobs.error();
  auto wanted = extras_of(flags, gates, places);
  if (!wanted) return wanted.error();
  const bool here = flags.server.empty();
  const unsigned processors = api::processors();
  const auto meshes = std::make_shared<check::Meshes>(gates, (here ? 1U : 0U) + wanted->turns());
  auto batches = std::make_unique<Batches>();
  auto measurer = here ? check::local(gates, meshes, {processors, *jobs}) : service_of(flags, *jobs, *batches);
  if (!measurer) return measurer.error();
  // The threads that measure make pictures and maps, while other gates run under a deadline.
  const auto seats = std::min<std::size_t>((*measurer)->at_once(), gates.size());
  auto extras = std::make_unique<CheckExtras>(meshes, gates.size(), *std::move(wanted),
                                              check::Processors::part(processors, seats));
  return RunParts{std::move(batches), meshes, std::move(*measurer), std::move(extras)};
}

Report measure(const CheckFlags& flags, const Gates& gates, RunParts& parts, const Interrupts& interrupts) {
  const auto rule = undecided_rule(flags);
  check::ProgressDisplay display(stderr, check::terminal_columns(STDERR_FILENO), colours(flags, STDERR_FILENO));
  check::Watch watch;
  watch.interrupted = [&] { return interrupts.seen(); };
  watch.after = [&](std::size_t place, const auto& outcome, Control& control) {
    parts.extras->after(place, outcome, control);
  };
  const auto tell_batches = [&] {
    for (const std::string& link : parts.batches->fresh()) display.say("Seen in a browser at " + link);
  };
  watch.ended = [&](const auto& outcome, const auto& standing) {
    if (flags.quiet) return;
    tell_batches();
    display.ended(outcome, standing, rule);
  };
  if (!flags.quiet) {
    watch.standing = [&](const auto& standing) {
      tell_batches();
      display.show(standing);
    };
  }
  Report report = check::run(gates, *parts.measurer, watch);
  display.clear();
  report.undecided = rule;
  report.batches = parts.batches->all();
  return report;
}

// The pictures of the HTML report, of which those of gates that pass are made now.
Pictures draw_passing(const CheckFlags& flags, const Report& report, RunParts& parts, const Interrupts& interrupts) {
  check::ProgressDisplay display(stderr, check::terminal_columns(STDERR_FILENO), colours(flags, STDERR_FILENO));
  const auto told = [&](std::size_t done, std::size_t all) {
    if (!flags.quiet) display.show({all, done, {}, "pictures"});
  };
  Pictures pictures = parts.extras->pictures(
      report, api::processors(), [&] { return interrupts.seen(); }, told);
  display.clear();
  return pictures;
}

bool print_table(const CheckFlags& flags, const Report& report, bool to_stdout) {
  std::FILE* out = to_stdout ? stdout : stderr;
  const int file = to_stdout ? STDOUT_FILENO : STDERR_FILENO;
  const check::TableStyle style{colours(flags, file), flags.quiet, check::terminal_columns(file)};
  return std::fputs(check::for_log(check::to_table(report, style)).c_str(), out) >= 0 && std::fflush(out) == 0;
}

// Prints the table and writes the reports and maps, as many as possible. Returns the exit code.
int tell(const CheckFlags& flags, const Report& report, const ReportFiles& reports, const CheckExtras& extras) {
  int exit_code = report.exit_code();
  if (!print_table(flags, report, !reports.to_stdout()))
    exit_code = fail_on_one_line("the result could not be written");
  if (const auto written = reports.write(report); !written) exit_code = fail_on_one_line(written.error().message);
  for (const std::string& note : extras.notes()) fail_on_one_line(note);
  for (const std::string& problem : extras.problems()) exit_code = fail_on_one_line(problem);
  return exit_code;
}

// Ends the process without destructors after an interruption, which freeing large meshes would delay, and while a
// reader is left behind, which uses what exit() destroys.
void leave_at_once_if_cut(bool interrupted, const check::Meshes& meshes, int exit_code) {
  if (!meshes.reading() && !interrupted) return;
  std::fflush(nullptr);
  std::_Exit(exit_code);
}

// Writes the mistakes into all reports, so that an earlier run's reports are not taken for those of this run.
int refuse(const CheckFlags& flags, const Asked& asked) {
  for (const check::Mistake& mistake : asked.mistakes)
    fail_on_one_line(asked.manifest.empty() ? mistake.message : check::to_string(asked.manifest, mistake));
  for (const std::string& line : asked.explanation)
    std::fprintf(stderr, "%s\n", check::for_log(check::shown_name(line)).c_str());
  const Pictures none;
  const ReportFiles reports = reports_of(flags, none);
  Places places = inputs_of(flags, {});
  if (const auto ok = reports.possible(places); !ok) return fail_on_one_line(ok.error().message);
  const auto written = reports.write(check::mistaken(asked.manifest, asked.mistakes));
  return written ? kExitError : fail_on_one_line(written.error().message);
}

int refuse(const CheckFlags& flags, const Error& error) { return refuse(flags, {{}, {{0, 0, error.message}}, ""}); }

// nullopt without --history.
Result<std::optional<check::History>> history_of(const CheckFlags& flags, Places& places) {
  if (flags.history.empty()) return std::optional<check::History>();
  if (auto ok = places.writes("--history", flags.history); !ok) return ok.error();
  auto history = check::History::open(flags.history);
  if (!history) return history.error();
  return std::optional(std::move(*history));
}

Result<Done> keep(std::optional<check::History>& history, Report& report) {
  if (!history) return Done{};
  return history->keep(api::to_utc(std::chrono::system_clock::now()), check::commit_of_pipeline(), report);
}

// What cannot be read is said, and changes neither verdict nor exit code.
check::Earlier earlier_run_of(const CheckFlags& flags) {
  check::Earlier earlier = check::earlier_run(flags.since);
  if (!earlier.problem.empty()) fail_on_one_line("--since: " + earlier.problem);
  return earlier;
}

// Reads those of two mesh files that are pipes.
Result<Done> take_pipes(const CheckFlags& flags, Gates& gates) {
  if (flags.files.size() != 2) return Done{};
  auto files = with_pipes(flags.files[0], flags.files[1]);
  if (!files) return files.error();
  for (check::Gate& gate : gates) {
    gate.candidate = files->a;
    gate.baseline = files->b;
    gate.pipes = files->pipes;
  }
  return Done{};
}

// Reads the baselines of --against; nullopt without it.
Result<std::optional<check::Revision>> revision_of(const CheckFlags& flags, Gates& gates,
                                                   const std::vector<check::OpenBaselines>& open,
                                                   const Interrupts& interrupts) {
  if (!flags.is_against) return std::optional<check::Revision>();
  const bool of_manifest = flags.files.size() == 1;
  auto revision = check::Revision::open(
      flags.against, of_manifest ? std::filesystem::path(flags.files[0]).parent_path() : std::filesystem::path(),
      [&] { return interrupts.seen(); });
  if (!revision) return revision.error();
  if (auto ok = revision->take_baselines(gates, open); !ok) return ok.error();
  return std::optional(std::move(*revision));
}

int check_gates(const CheckFlags& flags, Asked asked) {
  Gates& gates = asked.gates;
  Pictures pictures;
  const ReportFiles reports = reports_of(flags, pictures);
  Places places = inputs_of(flags, gates);
  if (const auto ok = reports.possible(places); !ok) return fail_on_one_line(ok.error().message);
  auto history = history_of(flags, places);
  if (!history) return refuse(flags, history.error());
  if (const auto ok = take_pipes(flags, gates); !ok) return refuse(flags, ok.error());
  const Interrupts interrupts;
  auto revision = revision_of(flags, gates, asked.open, interrupts);
  if (!revision) return refuse(flags, revision.error());
  auto parts = parts_of(flags, gates, places);
  if (!parts) return refuse(flags, parts.error());
  use_huge_pages();
  Report report = measure(flags, gates, *parts, interrupts);
  if (*revision) report.against = (*revision)->name();
  const auto kept = keep(*history, report);
  if (!flags.since.empty()) report.since = earlier_run_of(flags);
  pictures = draw_passing(flags, report, *parts, interrupts);
  int exit_code = tell(flags, report, reports, *parts->extras);
  if (!kept) exit_code = fail_on_one_line(kept.error().message);
  if (*revision) (*revision)->remove_copies();
  leave_at_once_if_cut(report.interrupted, *parts->meshes, exit_code);
  return exit_code;
}

// What --update-baselines does to the baselines of some gates, and why.
struct Selected {
  Gates gates;                               // whose candidates are copied
  std::map<std::string, std::string> why{};  // by the gate's name: "0.0968 .. 0.0977 mm apart, at most 0.05 mm"
  std::vector<std::string> left{};           // a line for each gate that passes
  std::shared_ptr<check::Meshes> meshes{};   // null: nothing was measured
};

bool has_baseline(const check::Gate& gate) {
  std::error_code none;
  return std::filesystem::exists(std::filesystem::symlink_status(gate.baseline, none));
}

// Measures the gates that have a baseline and a limit, and selects those that do not pass.
Result<Selected> differing(const CheckFlags& flags, const Gates& gates) {
  Selected selected;
  Gates asked;
  for (const check::Gate& gate : gates) {
    const bool is_known = has_baseline(gate) && has_limit(gate.request.options);
    (is_known ? asked : selected.gates).push_back(gate);
  }
  if (asked.empty()) return selected;
  Places places = inputs_of(flags, asked);
  auto parts = parts_of(flags, asked, places);
  if (!parts) return parts.error();
  const Interrupts interrupts;
  use_huge_pages();
  const Report report = measure(flags, asked, *parts, interrupts);
  if (report.interrupted) return refused("interrupted: no baseline was changed");
  selected.meshes = parts->meshes;
  for (const check::GateOutcome& outcome : report.outcomes) {
    if (outcome.verdict() == check::Verdict::pass) {
      selected.left.push_back("leave " + outcome.gate.baseline.string() + ": " + outcome.gate.candidate.string() +
                              " is within the limit, " + check::interval_of(outcome));
      continue;
    }
    selected.gates.push_back(outcome.gate);
    if (outcome.measured)
      selected.why[outcome.gate.name] = check::interval_of(outcome) + " apart, at most " + check::limit_of(outcome);
  }
  return selected;
}

Result<Selected> selected_by(const CheckFlags& flags, const Gates& gates) {
  if (flags.update == kUpdateDiffering) return differing(flags, gates);
  Selected selected{gates};
  if (flags.update == kUpdateMissing) std::erase_if(selected.gates, has_baseline);
  return selected;
}

int update(const CheckFlags& flags, const Selected& selected) {
  const check::Updates updates = check::plan_updates(selected.gates);
  for (const check::Mistake& mistake : updates.mistakes)
    fail_on_one_line(flags.files.size() == 1 ? check::to_string(flags.files[0], mistake) : mistake.message);
  if (!updates.mistakes.empty()) return kExitError;
  if (!flags.dry_run) {
    if (const auto done = check::carry_out(updates); !done) return fail_on_one_line(done.error().message);
  }
  std::vector<std::string> lines = selected.left;
  for (const check::Update& update : updates.updates) {
    const auto why = selected.why.find(update.gate);
    lines.push_back(check::to_string(update) + (why == selected.why.end() ? "" : ": " + why->second));
  }
  for (const std::string& line : lines) std::printf("%s\n", check::for_log(check::shown_name(line)).c_str());
  if (std::fflush(stdout) != 0) return fail_on_one_line("the result could not be written");
  return kExitResult;
}

int update_baselines(const CheckFlags& flags, const Gates& gates) {
  const auto selected = selected_by(flags, gates);
  if (!selected) return fail_on_one_line(selected.error().message);
  const int exit_code = update(flags, *selected);
  if (selected->meshes) leave_at_once_if_cut(false, *selected->meshes, exit_code);
  return exit_code;
}

int run(const CheckFlags& flags) {
  Asked asked = gates_asked(flags);
  if (!asked.mistakes.empty()) return refuse(flags, asked);
  return !flags.update.empty() ? update_baselines(flags, asked.gates) : check_gates(flags, std::move(asked));
}

}  // namespace

void add_check(CLI::App& app, int& exit_code) {
  CLI::App& command =
      *app.add_subcommand("check", "Check meshes against baselines: exit 0 pass, 1 fail, 2 undecided, 3 error");
  const auto flags = std::make_shared<CheckFlags>();
  declare(command, *flags);
  command.callback([flags, &command, &exit_code] {
    take_manifest_here(*flags);
    take_own_baseline(*flags);
    exit_code = flags->init ? write_first_manifest(*flags, unheard_by_init(command)) : run(*flags);
  });
}

}  // namespace meshgauge::cli
