// The outcomes as Markdown, for the summary of a job (GITHUB_STEP_SUMMARY) or a comment on a merge request.
#pragma once

#include <cstddef>
#include <string>

#include "check/outcome.h"

namespace meshgauge::check {

// GitHub refuses a summary of more than 1 MiB, and a step may add something of its own.
inline constexpr std::size_t kMarkdownBytes = 900'000;

// Failures first; gates that passed are folded. Names are in code spans and sentences are escaped: nothing in them is
// read as Markdown, HTML, a link, a mention or a reference. Never longer than max_bytes (at least 1000): gates that do
// not fit are counted in one last line.
std::string to_markdown(const Report& report, std::size_t max_bytes = kMarkdownBytes);

}  // namespace meshgauge::check
