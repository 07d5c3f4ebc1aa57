// The mesh files of a run: each is read and prepared once, shared by all gates that need it, and let go with the last
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

#include "api/prepared_mesh.h"
#include "check/gate.h"
#include "engine/control.h"
#include "engine/result.h"

namespace meshgauge::check {

// Thread safe. Files are read on threads of their own, which may outlive this object and even main(): the readers do
// not ask whether to give up. The process should end by _Exit() while one is reading().
class Meshes {
 public:
  // `gates`: all that will come; each is done() with its two files `turns` times.
  explicit Meshes(const std::vector<Gate>& gates, unsigned turns = 1);

  // Begins to read, unless somebody has already.
  void begin(const std::filesystem::path& file);

  // Waits until the file is read. An Error is about the file and names it, or is out_of_time when `control` said to
  // stop. Precondition: of a gate that is not done.
  Result<api::SharedMesh> get(const std::filesystem::path& file, Control& control);

  bool reading() const { return *readers_ > 0; }

  void done(const Gate& gate) noexcept;

 private:
  using File = std::shared_future<Result<api::SharedMesh>>;
  struct Entry {
    std::size_t uses = 0;  // still to come
    Prepared::Use use = Prepared::Use::once;
    File file;  // not valid: not asked for yet
  };

  File begun(const std::filesystem::path& file);

  // Of this object and of readers that outlive it.
  const std::shared_ptr<std::atomic<int>> readers_ = std::make_shared<std::atomic<int>>(0);
  std::mutex mutex_;  // guards what follows
  std::map<std::string, Entry> entries_;
  // Which of them a file is, as it was when the run began: links may be moved and files removed meanwhile.
  std::map<std::filesystem::path, Entry*> of_file_;
};

// One of the turns with a gate's meshes: done with its end, however that comes.
struct Turn {
  ~Turn() { meshes.done(gate); }
  Meshes& meshes;
  const Gate& gate;
};

}  // namespace meshgauge::check
