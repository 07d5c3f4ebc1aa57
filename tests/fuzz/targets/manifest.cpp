// A manifest of gates. Asserted: what is said has a place in the file or is about all of it, and can be shown; what is
// accepted is what a service would read of it. Files are not looked for: the globs and names of an
// accepted manifest are filled in for a name made up.
#include <algorithm>
#include <string>

#include <nlohmann/json.hpp>

#include "api/base/utf8.h"
#include "api/options/quantity.h"
#include "api/options/request.h"
#include "check/manifest/glob.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/naming.h"
#include "check/manifest/yaml_tree.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using namespace check;

void require_sound(const Entry& entry) {
  const api::Request& request = entry.gate.request;
  require(has_limit(request.options), "a gate has a limit");
  require(!entry.name.text.empty() && entry.name.text.size() <= kMaxNameBytes && is_utf8(entry.name.text),
          "the name is a text");
  require(check_glob(entry.candidate.text).ok() && check_template(entry.baseline.text).ok(), "patterns are checked");
  const std::string name = filled(entry.name.text, name_parts("part.stl.gz", "near"));
  require(name.find_first_of("{}") == std::string::npos, "no placeholder is left", name);
  // What a service is asked is what the manifest says.
  const std::string json = json_of(request).dump();
  const auto again = api::parse_options(json);
  require(again.ok() && json_of(*again).dump() == json, "a gate's request is read by a service as the same", json);
}

void require_shown(const std::vector<Mistake>& mistakes, std::string_view text) {
  const auto lines = static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 3;
  for (const Mistake& mistake : mistakes) {
    require(mistake.line >= 0 && mistake.line <= lines && mistake.column >= 0, "a mistake has a place in the file");
    require((mistake.line == 0) == (mistake.column == 0), "a place is whole", mistake.message);
    require(!mistake.message.empty() && mistake.message.size() < 1000, "a mistake is said shortly", mistake.message);
    require(find_control(mistake.message) == std::string::npos, "a mistake is on one line", mistake.message);
  }
  require(mistakes.size() <= Mistakes::kMost + 1, "mistakes have an end");
}

void check_manifest(std::string_view text) {
  Mistakes found;
  const auto entries = read_manifest(text, found);
  const auto mistakes = std::move(found).sorted();
  if (!mistakes.empty()) return require_shown(mistakes, text);
  require(!entries.empty(), "an accepted manifest has gates");
  for (const Entry& entry : entries) require_sound(entry);
}

// What stands alone as a flag.
void check_quantities(std::string_view text) {
  if (const auto limit = api::parse_length(text, true)) {
    require(api::in_range(limit->number, api::kMaxDistanceRange, "limit").ok(), "the limit is in range");
    require(!limit->unit || !limit->is_share, "a share has no unit");
  }
  if (const auto duration = api::parse_duration(text, std::chrono::minutes(3))) {
    require(duration->count() >= 1 && duration->count() <= 180'000, "a duration is in range");
  }
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(manifest) {
  const auto text = meshgauge::fuzz::text_of(data, size);
  meshgauge::fuzz::check_manifest(text);
  meshgauge::fuzz::check_quantities(text);
  return 0;
}
