#include "check/remote/pair.h"

#include <utility>

#include "api/options/request.h"

namespace meshgauge::check::service {

using Json = nlohmann::ordered_json;

std::string document_of(const Json& asked) { return asked.dump(-1, ' ', false, Json::error_handler_t::replace); }

Result<Done> Pair::send() {
  if (auto ok = send(a_, Sender::Part::candidate); !ok) return ok;
  return send(b_, Sender::Part::baseline);
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

Json Pair::asked() const { return {{"a", a_.id}, {"b", b_.id}, {"options", api::json_of(gate_.request)}}; }

bool Pair::is_ours(const Json& document) const {
  return sha256_of(document, "a") == a_.id && sha256_of(document, "b") == b_.id && is_answer_to(document, gate_);
}

End Pair::end_of(Job job) const {
  End end;
  if (job.result && is_ours(*job.result)) end.document = std::move(job.result);
  end.problem = std::move(job.problem);
  return end;
}

}  // namespace meshgauge::check::service
