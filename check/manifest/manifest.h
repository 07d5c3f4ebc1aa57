// Reads gates.yaml: which files to check, and how. gates.schema.json has its keys with examples.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "check/gate.h"
#include "check/manifest/mistake.h"
#include "engine/control.h"

namespace meshgauge::check {

inline constexpr std::size_t kMaxGates = 10'000;

// `may_be_missing` is for --update-baselines, `of_revision` for --against: they are looked up later, and may have the
// paths of their candidates.
enum class Baselines { must_exist, may_be_missing, of_revision };

// Selects gates of a manifest by name: --only.
class Selection {
 public:
  Selection() = default;  // all gates
  // Selects the gates that one of the patterns matches. Patterns have *, ? and [..]; '?' stands for one character of
  // UTF-8.
  explicit Selection(std::vector<std::string> patterns) : patterns_(std::move(patterns)) {}

  const std::vector<std::string>& patterns() const { return patterns_; }
  bool holds(std::string_view name) const;

  // Whether a name of this pattern could be selected; the pattern is the name of a gate whose candidate was not
  // found. When in doubt: true.
  bool may_hold(std::string_view name_pattern) const;

 private:
  std::vector<std::string> patterns_;
};

// The template of a glob's baselines. A revision is searched for files that match it and are the baseline of no gate.
struct OpenBaselines {
  Gate gate;                     // what is asked of each, without names and files; its line is that of the template
  std::filesystem::path folder;  // where the pattern begins
  std::string pattern;           // glob.h
  std::string lack;              // "has no candidate: 'parts/*.stl' finds none": of one that no gate has
};

struct Gates {
  std::vector<Gate> gates;
  std::vector<Mistake> mistakes;      // if any: nothing is measured; they have the defects of the gates as well
  std::vector<OpenBaselines> open{};  // with Baselines::of_revision: those of the revision need a candidate, too
};

// Returns all that is wrong: the mistakes or, without any, the defects of the gates: "gate 'x': the baseline ...".
std::vector<Mistake> defects_of(const Gates& read);

// Reads a manifest and looks up the files of the gates in `only`; files of other gates, which are returned as well,
// need not exist. Reports every mistake, not only the first. Paths in it are relative to its folder. A file that is
// missing is a defect of its gate alone. Limits: kMaxYamlBytes, kMaxYamlDepth and kMaxYamlNodes (yaml_tree.h),
// kMaxGates, and kMaxGlobEntries for each glob.
Gates gates_of(const std::filesystem::path& manifest, Baselines baselines = Baselines::must_exist,
               const Selection& only = {});

// As gates_of(), for a client that is not trusted: finds the manifest by the roots (Roots::find), reads and lists
// nothing outside of them, and follows no symbolic link below them. Absolute paths in the manifest and '..' are
// mistakes. The gates have these confines. kMaxGlobEntries is for all globs together. When `interrupted` says so, globs
// end, which is a mistake.
Gates gates_within(const std::shared_ptr<const api::Confines>& confines, const std::string& manifest,
                   const Selection& only = {}, const Interrupted& interrupted = never_interrupted);

// Returns globs of every baseline that candidates of the glob `candidate` could have by the template `baseline`: for
// "build/**/x-*.stl" and "base/{dir}/{stem}.off" it is "base/**/x-*.off". Together they may match more files, never
// fewer. They find baselines whose candidate was not written: the glob of the candidates cannot show them. "{dir}"
// beside text, as in "base/{dir}.off", takes two: for one folder and for more.
std::vector<std::string> baseline_globs(std::string_view candidate, std::string_view baseline);

}  // namespace meshgauge::check
