#include "api/deviation_map.h"

#include "api/deviation_csv.h"
#include "api/deviation_glb.h"
#include "api/deviation_ply.h"
#include "api/deviation_vtp.h"

namespace meshgauge::api {

Result<Done> write_deviation(const DeviationMap& map, MapKind kind, std::ostream& out) {
  switch (kind) {
    case MapKind::ply:
      return write_deviation_ply(map, out), Done{};
    case MapKind::glb:
      return write_deviation_glb(map, out);
    case MapKind::vtp:
      return write_deviation_vtp(map, out), Done{};
    default:
      return write_deviation_csv(map, out), Done{};
  }
}

}  // namespace meshgauge::api
