#include "api/formats/read_part.h"

#include <new>

#include "api/formats/file/source.h"
#include "api/formats/weld.h"

namespace meshgauge::api {

Result<ReadMesh> read_part(std::span<const std::byte> bytes, const ReadHints& hints, const ReadLimits& limits) {
  auto read = read_mesh(bytes, hints, limits, Corners::merged);
  if (!read || read->merged) return read;
  try {
    // Formats without indices repeat every corner; merged vertices save the engine most of its queries.
    const bool repeats_corners = read->mesh.positions.size() == 3 * read->mesh.triangles.size();
    if (repeats_corners) read->notes.welded_vertices = weld(read->mesh);
  } catch (const std::bad_alloc&) {
    return out_of_memory(hints.part);
  }
  return read;
}

}  // namespace meshgauge::api
