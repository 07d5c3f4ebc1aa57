// A gate as a request to the service: two stored meshes and a limit.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "check/gate.h"
#include "check/remote/answer.h"
#include "check/remote/sender.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// The result of one attempt: a document, or why there is none.
struct End {
  std::optional<nlohmann::ordered_json> document;
  std::optional<Problem> problem;
  bool lost = false;  // the service no longer knows the comparison
};

// For one thread at a time. Borrows all arguments.
class Pair {
 public:
  Pair(Sender& sender, const Gate& gate, Control& control) : sender_(sender), gate_(gate), control_(control) {}

  // Computes the limits and stores both meshes at the service. Blocks.
  Result<Done> send();

  // Makes the next send() upload this mesh, "a" or "b", without asking, since the service has lost it. False: it was
  // uploaded again before.
  bool forget(const std::string& part);

  const Gate& gate() const { return gate_; }
  // Precondition of the following: send() has succeeded.
  const Limits& limits() const { return *limits_; }  // a share of the diagonal is in the baseline's own unit
  nlohmann::ordered_json asked() const;

  // Whether the document is about these meshes and options. A proxy may answer with something else.
  bool is_ours(const nlohmann::ordered_json& document) const;
  // Precondition: the job has ended.
  End end_of(Job job) const;

 private:
  struct Mesh {
    std::string id;
    bool forgotten = false;   // upload without asking
    bool sent_again = false;  // uploaded again once
  };

  Result<Done> find_limits();
  Result<Done> send(Mesh& mesh, Sender::Part part);

  Sender& sender_;
  const Gate& gate_;
  Control& control_;
  std::optional<Limits> limits_;
  Mesh a_, b_;
};

}  // namespace meshgauge::check::service
