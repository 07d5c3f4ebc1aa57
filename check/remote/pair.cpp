#include "check/remote/pair.h"

#include <utility>

#include "check/remote/request.h"

namespace meshgauge::check::service {

using Json = nlohmann::ordered_json;

Result<Done> Pair::send() {
  if (auto ok = find_limits(); !ok) return ok;
  if (auto ok = send(a_, Sender::Part::candidate); !ok) return ok;
  return send(b_, Sender::Part::baseline);
}

Result<Done> Pair::find_limits() {
  if (limits_) return Done{};
  Result<double> diagonal = 0.0;
  if (has_diagonal_share(gate_)) diagonal = sender_.baseline_diagonal(gate_, control_);
  if (!diagonal) return diagonal.error();
  limits_ = limits_of(gate_, *diagonal);
  return Done{};
}

Result<Done> Pair::send(Mesh& mesh, Sender::Part part) {
  auto id = sender_.stored(gate_, part, control_, std::exchange(mesh.forgotten, false));
  if (!id) return std::move(id).error();
  mesh.id = std::move(*id);
  return Done{};
}

bool Pair::forget(const std::string& part) {
  Mesh& mesh = part == "a" ? a_ : b_;
  mesh.forgotten = true;
  return !std::exchange(mesh.sent_again, true);
}

Json Pair::asked() const { return asked_of(a_.id, b_.id, gate_, *limits_); }

bool Pair::is_ours(const Json& document) const {
  return sha256_of(document, "a") == a_.id && sha256_of(document, "b") == b_.id &&
         is_answer_to(document, gate_, *limits_);
}

End Pair::end_of(Job job) const {
  End end;
  if (job.result && is_ours(*job.result)) end.document = std::move(job.result);
  end.problem = std::move(job.problem);
  return end;
}

}  // namespace meshgauge::check::service
