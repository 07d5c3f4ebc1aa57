#include "api/compare/load.h"

#include <utility>

#include "api/base/digest.h"
#include "api/formats/read_part.h"

namespace meshgauge::api {

Result<LoadedMesh> load(const MeshInput& input, const ReadLimits& limits) {
  auto read = read_part(input.bytes, {input.part, input.filename, input.media_type}, limits);
  if (!read) return std::move(read).error();
  const auto mesh = std::make_shared<const Mesh>(std::move(read->mesh));
  return LoadedMesh{*mesh, read->format, read->notes, sha256_hex(input.bytes), mesh, std::move(read->groups)};
}

Error not_in_time(Interruption why, const std::string& what) {
  const std::string how = why == Interruption::timeout ? "timed out before " : "cancelled before ";
  return Error{ErrorCode::out_of_time, how + what, "", ""};
}

Result<Done> in_time(Control& control, const std::string& what) {
  const Interruption why = control.check();
  if (why == Interruption::none) return Done{};
  return not_in_time(why, what);
}

}  // namespace meshgauge::api
