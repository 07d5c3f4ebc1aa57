// A gate as the service is asked about it: two meshes that are there, and a limit.
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

// What came of asking once: a document, or why there is none.
struct End {
  std::optional<nlohmann::ordered_json> document;
  std::optional<Problem> problem;
  bool lost = false;  // the service does not know the comparison any more
};

// For one thread at a time. Borrows all.
class Pair {
 public:
  Pair(Sender& sender, const Gate& gate, Control& control) : sender_(sender), gate_(gate), control_(control) {}

  // The limit is known, and the service has both meshes when this returns.
  Result<Done> send();

  // The service has said that it has this mesh no more, "a" or "b": the next send() sends it without asking. False: it
  // said so before.
  bool forget(const std::string& part);

  const Gate& gate() const { return gate_; }
  // Preconditions of what follows: sent.
  double max_distance() const { return *max_distance_; }  // the gate's limit, a share in the baseline's own unit
  nlohmann::ordered_json asked() const;

  // Whatever stands between may have its own idea of what was asked.
  bool is_ours(const nlohmann::ordered_json& document) const;
  // Precondition: the job has ended.
  End end_of(Job job) const;

 private:
  struct Mesh {
    std::string id;
    bool forgotten = false;   // it is to be sent without asking
    bool sent_again = false;  // that was done
  };

  Result<Done> find_limit();
  Result<Done> send(Mesh& mesh, Sender::Part part);

  Sender& sender_;
  const Gate& gate_;
  Control& control_;
  std::optional<double> max_distance_;
  Mesh a_, b_;
};

}  // namespace meshgauge::check::service
