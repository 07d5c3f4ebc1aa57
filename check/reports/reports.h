// Writes outcomes in the forms that pipelines and code hosts read.
#pragma once

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// JUnit XML: a test suite with one test for each gate. Valid by the schema of Ant's reports (windyroad's JUnit.xsd, the
// strictest) and by that of Jenkins, for any file name. A gate that counts as failed is a <failure> of type fail or
// undecided; one that could not be measured is an <error>; one that only warns has passed, and its <system-out> says
// so. The suite's properties hold the interval, the limit and the witness with all digits. `when`: time of the run,
// which the schema requires.
std::string to_junit(const Report& report,
                     std::chrono::system_clock::time_point when = std::chrono::system_clock::now());

// Below GitHub's limit of 1 MiB for a summary, which other steps add to.
inline constexpr std::size_t kMarkdownBytes = 900'000;

// Markdown, for the summary of a job (GITHUB_STEP_SUMMARY): what changed since Report::since, then failures first;
// passed gates are folded. Names are code spans and sentences are escaped, so that nothing in them is read as Markdown,
// HTML, a link, a mention or a reference. At most max_bytes long (at least 1000); the last line counts the gates that
// do not fit.
std::string to_markdown(const Report& report, std::size_t max_bytes = kMarkdownBytes);

// The same for a comment on a pull request. Of gates that do not pass, limits that are kept are in the fold. Behind the
// advice of each measured one stands `<!-- picture: NAME -->`, which is not shown, for a link to the picture where
// there is one; NAME is that of check/picture_name.h.
inline constexpr std::size_t kCommentBytes = 60'000;  // GitHub takes 65,536 characters
std::string to_comment(const Report& report, std::size_t max_bytes = kCommentBytes);

// Lines of GitHub's workflow commands, "::error file=gates.yaml,line=7,title=...::Gate 'lid': ...", which its pages
// show at the gate's line of the manifest (without a manifest: at the candidate): error for what counts, warning for a
// fail and notice for an undecided that are allowed, and for a pass of which something was not measured. Escaped as
// GitHub's toolkit does. At most ten of each, since GitHub shows no more of a step: the worst first, the last one
// counts the others. `top`: folder of the repository, absolute, that files are named from; empty: they stay as they
// are.
std::string to_annotations(const Report& report, const std::filesystem::path& top = {});

// SARIF 2.1.0, for GitHub's code scanning and other viewers. Each gate that did not pass is a result at its line of the
// manifest (without a manifest: at the candidate), with both files as related locations. Level: error for what counts,
// warning for a fail and note for an undecided that are allowed. Passed gates are counted in the run's properties,
// since viewers take every result for a finding. The fingerprint is fingerprint_of() (finding.h).
std::string to_sarif(const Report& report);

// GitLab's Code Quality report, which merge requests show, in the form of Code Climate: a finding for each gate that
// did not pass, at its line of the manifest. Severity: critical for an error, major for a fail or an undecided that
// counts, minor for a fail and info for an undecided that are allowed.
std::string to_code_quality(const Report& report);

}  // namespace meshgauge::check
