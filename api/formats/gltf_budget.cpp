#include "api/formats/gltf_budget.h"

#include <algorithm>

#include "api/formats/expansion.h"

namespace meshgauge::api {

GltfBudget::GltfBudget(const Source& sent)
    : sent_(sent),
      most_bytes_(expansion_limit(sent.bytes.size(), sent.limits)),
      most_steps_(kFreeSteps + kStepsPerByte * sent.bytes.size()) {}

Result<Done> GltfBudget::take(std::size_t bytes) {
  if (bytes > most_bytes_ - bytes_) {
    return expands_too_far(sent_.part, most_bytes_, sent_.bytes.size(), "compressed glTF");
  }
  bytes_ += bytes;
  return Done{};
}

Result<Done> GltfBudget::work(std::size_t steps, const std::string& where) {
  if (steps > most_steps_ - steps_) {
    return at(
        sent_, where, ErrorCode::too_large,
        "takes too long: nodes, instances, primitives and morph targets read the same numbers more often than the "
        "limit for a file of " +
            std::to_string(sent_.bytes.size()) +
            " bytes; remove objects without triangles, or save the model without instances");
  }
  steps_ += steps;
  return Done{};
}

void GltfBudget::refund(std::size_t since, std::size_t triangles) {
  steps_ -= std::min(steps_ - since, kStepsPerTriangle * triangles);
}

}  // namespace meshgauge::api
