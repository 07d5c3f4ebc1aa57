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

// Returns the body of a request. What is not UTF-8 in a name becomes U+FFFD.
std::string document_of(const nlohmann::ordered_json& asked);

// For one thread at a time. Borrows all arguments.
class Pair {
 public:
  Pair(Sender& sender, const Gate& gate, Control& control) : sender_(sender), gate_(gate), control_(control) {}

  // Stores both meshes at the service. Blocks.
  Result<Done> send();

  // Makes the next send() upload this mesh, "a" or "b", without asking, since the service has lost it. False: it was
  // uploaded again before.
  bool forget(const std::string& part);

  const Gate& gate() const { return gate_; }
  // Precondition of the following: send() has succeeded.
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

  Result<Done> send(Mesh& mesh, Sender::Part part);

  Sender& sender_;
  const Gate& gate_;
  Control& control_;
  Mesh a_, b_;
};

}  // namespace meshgauge::check::service
