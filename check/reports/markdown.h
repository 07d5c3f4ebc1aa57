// Writes outcomes as Markdown, for the summary of a job (GITHUB_STEP_SUMMARY) or a comment on a merge request.
#pragma once

#include <cstddef>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// Below GitHub's limit of 1 MiB for a summary, which other steps add to.
inline constexpr std::size_t kMarkdownBytes = 900'000;

// Returns failures first; passed gates are folded. Names are code spans and sentences are escaped, so that nothing in
// them is read as Markdown, HTML, a link, a mention or a reference. At most max_bytes long (at least 1000); the last
// line counts the gates that do not fit.
std::string to_markdown(const Report& report, std::size_t max_bytes = kMarkdownBytes);

}  // namespace meshgauge::check
