// Uploads the mesh files of a run: hashes each file once and sends it at most once.
#pragma once

#include <filesystem>
#include <string>

#include "check/gate.h"
#include "check/remote/client.h"
#include "check/remote/lazy_map.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check::service {

// Thread safe. Errors name the file, or are about the service.
class Sender {
 public:
  explicit Sender(Client& client) : client_(client) {}

  enum class Part { candidate, baseline };

  // Stores the gate's mesh at the service and returns its id. Blocks. `forgotten`: the service has lost the mesh, so
  // it is sent without asking.
  Result<std::string> stored(const Gate& gate, Part part, Control& control, bool forgotten = false);

  // Forgets which meshes were delivered; the service is asked again for each.
  void doubt() { delivered_.forget_all(); }

 private:
  Result<std::string> hash(const Gate& gate, const std::filesystem::path& file, Control& control);
  Result<Done> deliver(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control,
                       bool forgotten);
  Result<Done> put(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control);

  Client& client_;
  LazyMap<std::string> ids_;  // by path
  LazyMap<Done> delivered_;   // by id
};

}  // namespace meshgauge::check::service
