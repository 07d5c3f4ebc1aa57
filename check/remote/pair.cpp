#include "check/remote/pair.h"

#include <algorithm>
#include <utility>

#include "api/options/request.h"
#include "check/remote/answer.h"

namespace meshgauge::check::service {

Result<Done> Pair::send() {
  for (const auto& [id, part] : {std::pair(&a_, Sender::Part::candidate), std::pair(&b_, Sender::Part::baseline)}) {
    auto stored = sender_.stored(gate_, part, control_);
    if (!stored) return std::move(stored).error();
    *id = std::move(*stored);
  }
  return Done{};
}

void Pair::report(const Progress& progress) {
  progress_ = {std::max(progress_.lower, progress.lower), std::min(progress_.upper, progress.upper), progress.stage};
  control_.report(progress_);
}

nlohmann::ordered_json Pair::asked() const { return {{"a", a_}, {"b", b_}, {"options", api::json_of(gate_.request)}}; }

bool Pair::is_ours(const nlohmann::ordered_json& document) const {
  return sha256_of(document, "a") == a_ && sha256_of(document, "b") == b_ && is_answer_to(document, gate_);
}

}  // namespace meshgauge::check::service
