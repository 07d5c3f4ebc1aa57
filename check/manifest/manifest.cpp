#include "check/manifest/manifest.h"

#include <string>
#include <utility>
#include <vector>

#include "api/json_filter.h"
#include "api/refused.h"
#include "api/text_file.h"
#include "check/manifest/manifest_text.h"
#include "check/manifest/yaml_tree.h"
#include "engine/result.h"

namespace meshgauge::check {
namespace {

Result<std::string> read_file(const std::filesystem::path& file) {
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) return refused("is a folder: name the manifest in it");
  return api::read_text_file(file.string(), kMaxYamlBytes);
}

// Nothing is measured, so all is said at once.
void add_defects(const std::vector<Gate>& gates, Mistakes& mistakes) {
  for (const Gate& gate : gates) {
    for (const Mistake& defect : gate.defects)
      mistakes.add({defect.line, defect.column}, "gate " + api::shown_text(gate.name) + ": " + defect.message);
  }
}

}  // namespace

std::vector<Mistake> defects_of(const Gates& read) {
  if (!read.mistakes.empty()) return read.mistakes;
  Mistakes defects;
  add_defects(read.gates, defects);
  return std::move(defects).sorted();
}

Gates gates_of(const std::filesystem::path& manifest, Baselines baselines, const Selection& only) {
  Mistakes mistakes;
  Gates result;
  const auto text = read_file(manifest);
  if (text) {
    result.gates = expand(read_manifest(*text, mistakes), manifest, {baselines, only}, mistakes);
    if (!mistakes.empty()) add_defects(result.gates, mistakes);
  } else {
    mistakes.add({}, text.error().message);
  }
  result.mistakes = std::move(mistakes).sorted();
  return result;
}

}  // namespace meshgauge::check
