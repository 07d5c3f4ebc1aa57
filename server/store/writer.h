// Group commit: one thread with a connection of its own runs all waiting writes in one transaction. A disk syncs a few
// hundred times a second, which bounds the number of transactions, not of writes. Thread safe.
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
#include <utility>

#include "server/base/threads.h"
#include "server/store/reserve.h"
#include "server/store/sqlite.h"

namespace meshgauge::server::store {

class Writer {
 public:
  // Borrows the reserve and the files. With the files nothing is committed that the next process would not find.
  explicit Writer(std::unique_ptr<Connection> connection, Reserve* reserve = nullptr, const OpenFiles* files = nullptr);
  ~Writer() = default;  // precondition: no call of write() is under way
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  // Runs work(Connection&) on the writer's thread and blocks until it is committed. Returns its value; on an error
  // nothing of it is stored. Work may throw SQLite::Exception, which undoes it alone. It may run more than once; what
  // it did before is undone then. `fleeting`: does not wait for the disk, so a crash of the machine may undo it; a
  // later durable write makes it durable, too. `removal`: durable, and may use the reserve when the disk is full.
  enum class Promise { durable, fleeting, removal };
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
  void tell_end();
  void gather(std::unique_lock<std::mutex>& lock);
  void run(std::span<Task> tasks);
  std::optional<Error> commit(std::span<Task> tasks);
  Result<Done> check_files();
  std::optional<Error> commit_from_reserve(Task& task);
  void give_back_room();
  bool run_one(Task& task);
  void sync_commits(bool synced);
  void roll_back();

  const std::unique_ptr<Connection> connection_;
  Reserve* const reserve_;        // null: there is none
  const OpenFiles* const files_;  // null: they are not checked
  std::mutex mutex_;
  std::condition_variable ready_;
  std::deque<Task> waiting_;
  bool ending_ = false;
  bool synced_ = true;                                   // used by the writer's thread alone: commits wait for the disk
  std::size_t last_tasks_ = 0;                           // used by the writer's thread alone: of its newest transaction
  std::chrono::steady_clock::duration last_duration_{};  // used by the writer's thread alone: of its newest transaction
  Threads threads_;
};

}  // namespace meshgauge::server::store
