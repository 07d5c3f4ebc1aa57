// `meshgauge check` before there is a manifest: explains it, and writes a first one.
#pragma once

#include <string>
#include <vector>

#include "cli/check_flags.h"

namespace meshgauge::cli {

// Takes the manifest of the current folder when no file is named and it exists.
void take_manifest_here(CheckFlags& flags);

// Returns lines for files that are neither a pair nor a manifest: what is wrong, then a manifest with these files and
// how to have it written. Empty: they may be a pair or a manifest.
std::vector<std::string> explain_manifest(const CheckFlags& flags);

// --init: writes gates.yaml into the folder. Returns the exit code. `unheard`: a flag that is given beside it and means
// nothing to it; empty: there is none.
int write_first_manifest(const CheckFlags& flags, const std::string& unheard);
std::string unheard_by_init(const CLI::App& command);

}  // namespace meshgauge::cli
