// Group commit: one thread with a connection of its own runs whatever waits to be written in one transaction. A disk
// syncs a few hundred times a second; so many transactions there are, however many writes wait.
#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "server/store/sqlite.h"

namespace meshgauge::server::store {

class Writer {
 public:
  explicit Writer(std::unique_ptr<Connection> connection);
  ~Writer();  // nobody waits any more
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Runs work(Connection&) on the writer's thread; returns its value once that is committed, or the error, and then
  // nothing of it is stored. The work may throw SQLite::Exception, which undoes it alone and not its neighbours; it may
  // be run more than once, with what it did before undone. `fleeting`: a crash of the machine may undo it, so it does
  // not wait for the disk; what is written durably after it makes it durable, too.
  enum class Promise { durable, fleeting };
  template <class Work>
  auto write(Work work, Promise promise = Promise::durable) -> Result<std::invoke_result_t<Work&, Connection&>> {
    std::optional<std::invoke_result_t<Work&, Connection&>> value;
    std::optional<Error> error = submit([&](Connection& connection) { value.emplace(work(connection)); }, promise);
    if (error) return std::move(*error);
    return std::move(*value);
  }

 private:
  struct Task {
    std::function<void(Connection&)> work;
    Promise promise;
    std::promise<std::optional<Error>> done;
    std::optional<Error> error;
  };

  std::optional<Error> submit(std::function<void(Connection&)> work, Promise promise);
  void loop();
  void gather(std::unique_lock<std::mutex>& lock);
  void run(std::span<Task> tasks);
  std::optional<Error> commit(std::span<Task> tasks);
  bool run_one(Task& task);
  void sync_commits(bool synced);
  void roll_back();

  const std::unique_ptr<Connection> connection_;
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<Task> waiting_;
  bool ending_ = false;
  bool synced_ = true;                                   // the writer's thread alone: commits wait for the disk
  std::size_t last_tasks_ = 0;                           // the writer's thread alone: of its newest transaction
  std::chrono::steady_clock::duration last_duration_{};  // likewise
  std::thread thread_;
};

}  // namespace meshgauge::server::store
