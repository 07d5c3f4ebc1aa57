#include "api/load.h"

#include <new>
#include <utility>

#include "api/digest.h"
#include "api/formats/source.h"
#include "api/formats/weld.h"

namespace meshgauge::api {

Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits) {
  auto read = read_mesh(bytes, hints, limits);
  if (!read) return read;
  try {
    // Formats without indices repeat every corner; shared vertices save the engine most of its queries.
    const bool repeats_corners = read->mesh.positions.size() == 3 * read->mesh.triangles.size();
    if (repeats_corners) read->notes.welded_vertices = weld(read->mesh);
  } catch (const std::bad_alloc&) {
    return out_of_memory(hints.part);
  }
  return read;
}

Result<LoadedMesh> load(const MeshInput& input, const ReadLimits& limits, Control& /*control*/) {
  auto read = read_part(input.bytes, {input.part, input.filename, input.media_type}, limits);
  if (!read) return std::move(read).error();
  const auto mesh = std::make_shared<const Mesh>(std::move(read->mesh));
  return LoadedMesh{*mesh, read->format, read->notes, sha256_hex(input.bytes), mesh};
}

Error not_in_time(Interruption why, const std::string& what) {
  const std::string how = why == Interruption::timeout ? "the time was over before " : "cancelled before ";
  return Error{ErrorCode::out_of_time, how + what, "", ""};
}

}  // namespace meshgauge::api
