// An OBJ file that is read is the same mesh to tinyobjloader, but for what that is known to do otherwise.
#include <string>

#include "api/formats/format.h"
#include "tests/api/formats/files.h"
#include "tests/api/formats/tinyobj_peer.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

FUZZ_TARGET(obj_tinyobj) {
  using namespace meshgauge;
  const auto text = fuzz::text_of(data, size);
  const auto ours = api::test::read(text, "m.obj");
  if (!ours || ours->format != api::Format::obj || ours->notes.gzip || !api::test::tinyobj_excuse(text).empty())
    return 0;
  const Mesh theirs = api::test::by_tinyobj(text, ours->mesh.positions);
  const bool cloud = ours->notes.cloud && theirs.triangles.empty();
  fuzz::require(cloud || ours->mesh.triangles == theirs.triangles, "the same triangles");
  fuzz::require(ours->mesh.positions.size() == theirs.positions.size(), "as many vertices");
  for (std::size_t i = 0; i < theirs.positions.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const double our = ours->mesh.positions[i][k], their = theirs.positions[i][k];
      fuzz::require(api::test::steps_apart(our, their) <= api::test::kMostTinyobjSteps, "the same coordinates",
                    std::to_string(our) + " and " + std::to_string(their));
    }
  }
  return 0;
}
