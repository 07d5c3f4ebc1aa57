// A baseline that has no candidate any more is how a part that was not written is seen: the glob of the candidates
// cannot know of it.
#pragma once

#include <string>
#include <string_view>

#include "check/manifest/naming.h"

namespace meshgauge::check {

// The glob of all baselines that candidates of the glob `candidate` could have, by the template `baseline`: of
// "build/**/x-*.stl" and "base/{dir}/{stem}.off" it is "base/**/x-*.off". Rather too many than too few.
std::string baseline_glob(std::string_view candidate, std::string_view baseline);

}  // namespace meshgauge::check
