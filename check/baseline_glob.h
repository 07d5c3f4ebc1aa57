// Finds baselines whose candidate was not written: the glob of the candidates cannot show them.
#pragma once

#include <string>
#include <string_view>

#include "check/manifest/naming.h"

namespace meshgauge::check {

// Returns a glob of every baseline that candidates of the glob `candidate` could have by the template `baseline`: for
// "build/**/x-*.stl" and "base/{dir}/{stem}.off" it is "base/**/x-*.off". It may match more files, never fewer.
std::string baseline_glob(std::string_view candidate, std::string_view baseline);

}  // namespace meshgauge::check
