// The mesh files of a run on their way to the service: each is looked at once, and travels at most once.
#pragma once

#include <filesystem>
#include <string>

#include "check/gate.h"
#include "check/remote/client.h"
#include "check/remote/once.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Thread safe. Errors are about the file and name it, or about the service.
class Sender {
 public:
  explicit Sender(Client& client) : client_(client) {}

  enum class Part { candidate, baseline };

  // The id of the gate's mesh, which the service has when this returns. `forgotten`: the service has said that it has
  // it no more, so it is sent without asking.
  Result<std::string> stored(const Gate& gate, Part part, Control& control, bool forgotten = false);

  // The service may have lost meshes: each is asked for anew.
  void doubt() { delivered_.forget_all(); }

  // Of the baseline's bounding box, bit by bit as measured here. Read on a thread of its own, which may outlive even
  // main() when this was cancelled: then the process should end by _Exit(), as with Meshes (check/run/meshes.h).
  Result<double> baseline_diagonal(const Gate& gate, Control& control);

 private:
  Result<std::string> hash(const std::filesystem::path& file, Control& control);
  Result<Done> deliver(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control,
                       bool forgotten);
  Result<Done> put(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control);

  Client& client_;
  Once<std::string> ids_;   // by path
  Once<Done> delivered_;    // by id
  Once<double> diagonals_;  // by path
};

}  // namespace meshgauge::check::service
