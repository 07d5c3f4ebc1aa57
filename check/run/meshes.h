// The mesh files of a run. Each is read and prepared once, shared by the gates that need it, and freed after the last
// of them.
#pragma once

#include <atomic>
#include <filesystem>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "api/compare/prepared_mesh.h"
#include "check/gate.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

// Thread safe. Each file is read by a thread of its own that may outlive this object and even main(), because readers
// cannot be cancelled. The process should end by _Exit() while reading() is true, or stop() be called before.
class Meshes {
 public:
  // `gates`: all that will come. done() is called `turns` times for each.
  explicit Meshes(const std::vector<Gate>& gates, unsigned turns = 1);

  // Starts to read the file unless it was started before.
  void begin(const std::filesystem::path& file);

  // Waits until the file is read. Errors name the file, or are out_of_time when `control` says to stop. Precondition:
  // the file is of a gate that is not done.
  Result<api::SharedMesh> get(const std::filesystem::path& file, Control& control);

  bool reading() const { return readers_->running > 0; }

  // Waits until nothing is read. Files that are not in memory yet are cancelled, where a reader can stop.
  void stop();

  void done(const Gate& gate) noexcept;

  // Gives the gate, one of those of the constructor, a further turn. Files that are no longer in memory are read again.
  void again(const Gate& gate);

 private:
  using File = std::shared_future<Result<api::SharedMesh>>;
  struct Entry {
    std::size_t uses = 0;  // turns still to come
    Prepared::Use use = Prepared::Use::once;
    std::shared_ptr<const api::Pipes> pipes;        // Gate::pipes
    std::shared_ptr<const api::Copies> copies;      // Gate::copies
    std::shared_ptr<const api::Confines> confines;  // Gate::confines
    File file;                                      // not valid: not requested yet
  };

  // Shared with readers that outlive this object.
  struct Readers {
    std::atomic<int> running{0};
    std::atomic<bool> stopped{false};
  };

  File begun(const std::filesystem::path& file);

  const std::shared_ptr<Readers> readers_ = std::make_shared<Readers>();
  std::mutex mutex_;  // guards the members below
  std::map<std::string, Entry> entries_;
  // The file of each path when the run began: links may change and files may be removed meanwhile.
  std::map<std::filesystem::path, Entry*> of_file_;
};

// Calls done() for one turn of a gate when it is destroyed.
struct Turn {
  ~Turn() { meshes.done(gate); }
  Meshes& meshes;
  const Gate& gate;
};

}  // namespace meshgauge::check
