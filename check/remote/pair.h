// A gate as a request to the service: two stored meshes and a limit.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "check/gate.h"
#include "check/remote/sender.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// For one thread at a time. Borrows all arguments.
class Pair {
 public:
  Pair(Sender& sender, const Gate& gate, Control& control) : sender_(sender), gate_(gate), control_(control) {}

  // Stores both meshes at the service. Blocks.
  Result<Done> send();

  // Reports the interval so far. It never widens, also if the work begins again after a restart.
  void report(const Progress& progress);

  const Gate& gate() const { return gate_; }
  // Precondition of the following: send() has succeeded.
  nlohmann::ordered_json asked() const;

  // Whether the document is about these meshes and options. A proxy may answer with something else.
  bool is_ours(const nlohmann::ordered_json& document) const;

 private:
  Sender& sender_;
  const Gate& gate_;
  Control& control_;
  std::string a_, b_;  // ids of the meshes
  Progress progress_;
};

}  // namespace meshgauge::check::service
