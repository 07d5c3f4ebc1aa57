#include "server/measure/equal_work.h"

#include <span>

#include "api/digest.h"
#include "engine/hausdorff.h"

namespace meshgauge::server {

std::string work_of(const store::NewJob& job) {
  constexpr const char* kForm = "1";  // of a result: another one after each change of what a result has
  const std::string all =
      job.mesh_a + "\n" + job.mesh_b + "\n" + job.hints + "\n" + job.options + "\n" + version() + "\n" + kForm;
  return api::sha256_hex(std::as_bytes(std::span(all)));
}

}  // namespace meshgauge::server
