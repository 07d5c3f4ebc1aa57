#include "check/manifest/manifest.h"

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "check/manifest/manifest_text.h"
#include "check/manifest/yaml_tree.h"
#include "engine/result.h"

namespace meshgauge::check {
namespace {

// One byte more than is taken, so that the limit is seen to be broken; a device without end is no problem.
Result<std::string> read_file(const std::filesystem::path& file) {
  const auto refused = [](std::string why) { return Error{ErrorCode::invalid_request, std::move(why), "", ""}; };
  std::error_code none;
  if (std::filesystem::is_directory(file, none)) return refused("is a folder, not a manifest");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refused(std::string("cannot be read: ") + std::strerror(errno));
  std::string text(kMaxYamlBytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return refused("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

}  // namespace

Gates gates_of(const std::filesystem::path& manifest, Baselines baselines, const Selection& only) {
  Mistakes mistakes;
  Gates result;
  const auto text = read_file(manifest);
  if (text) {
    result.gates = expand(read_manifest(*text, mistakes), manifest, {baselines, only}, mistakes);
  } else {
    mistakes.add({}, text.error().message);
  }
  result.mistakes = std::move(mistakes).sorted();
  return result;
}

}  // namespace meshgauge::check
