#include "server/store/writer.h"

#include <algorithm>
#include <exception>
#include <iterator>

#include <sqlite3.h>

#include "server/base/heap.h"

namespace meshgauge::server::store {
namespace {

// Bounds what one transaction adds to the log, and how long its first write waits for its last.
constexpr std::size_t kMostTasks = 512;

// Failures of one statement, after which the transaction can continue. Others concern the disk or the database.
bool concerns_one(const SQLite::Exception& exception) {
  const int code = exception.getErrorCode();
  return code == SQLITE_CONSTRAINT || code == SQLITE_TOOBIG || code == SQLITE_MISMATCH || code == SQLITE_RANGE ||
         code == SQLITE_ERROR;
}

}  // namespace

Writer::Writer(std::unique_ptr<Connection> connection, Reserve* reserve, const OpenFiles* files)
    : connection_(std::move(connection)), reserve_(reserve), files_(files), threads_([this] { tell_end(); }) {
  threads_.start([this] { loop(); });
}

void Writer::tell_end() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  ready_.notify_one();
}

std::optional<Error> Writer::submit(std::function<void(Connection&)> work, Promise promise) {
  Task task{std::move(work), promise, {}, {}};
  std::future<std::optional<Error>> done = task.done.get_future();
  {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(task));
  }
  ready_.notify_one();
  return done.get();
}

void Writer::loop() {
  const NeverFails never_fails;
  std::unique_lock lock(mutex_);
  while (true) {
    ready_.wait(lock, [&] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    gather(lock);
    const auto count = static_cast<std::ptrdiff_t>(std::min(waiting_.size(), kMostTasks));
    std::vector<Task> tasks(std::make_move_iterator(waiting_.begin()),
                            std::make_move_iterator(waiting_.begin() + count));
    waiting_.erase(waiting_.begin(), waiting_.begin() + count);
    lock.unlock();
    const auto start = std::chrono::steady_clock::now();
    run(tasks);
    last_duration_ = std::chrono::steady_clock::now() - start;
    last_tasks_ = tasks.size();
    for (Task& task : tasks) task.done.set_value(std::move(task.error));
    lock.lock();
  }
}

// Callers whose writes were just committed often write again at once. Taking the first of them alone would let the
// others wait for two transactions. So the writer waits for as many as there were, for a fraction of a transaction's
// time.
void Writer::gather(std::unique_lock<std::mutex>& lock) {
  ready_.wait_for(lock, last_duration_ / 8, [this] { return ending_ || waiting_.size() >= last_tasks_; });
}

void Writer::run(std::span<Task> tasks) {
  const bool full = reserve_ && !reserve_->restore();
  std::optional<Error> error = full ? Reserve::not_restored("the database cannot be written") : commit(tasks);
  if (!error) return;
  // A locked database takes 5 s to report that, for each write.
  const bool is_alone = tasks.size() == 1;
  if (error->code == ErrorCode::storage_unavailable || (is_alone && error->code != ErrorCode::storage_full)) {
    for (Task& task : tasks) task.error = error;
    return;
  }
  // One of them may be too large for the rest of the disk: the others must not fail with it.
  for (Task& task : tasks) {
    std::optional<Error> own = full || is_alone ? error : commit(std::span(&task, 1));
    const bool has_reserve = reserve_ && task.promise == Promise::removal;
    if (own && own->code == ErrorCode::storage_full && has_reserve) own = commit_from_reserve(task);
    if (own) task.error = std::move(own);
  }
}

std::optional<Error> Writer::commit_from_reserve(Task& task) {
  reserve_->release();
  std::optional<Error> error = commit(std::span(&task, 1));
  if (!reserve_->restore()) {
    give_back_room();
    reserve_->restore();  // if it fails, the disk counts as full until a later write finds room
  }
  return error;
}

// Returns the pages that deleted rows and the log held to the file system.
void Writer::give_back_room() {
  try {
    connection_->execute("PRAGMA busy_timeout = 200");  // a reader keeps the log for a moment: others wait meanwhile
    connection_->execute("PRAGMA incremental_vacuum(1000)");
    connection_->execute("PRAGMA wal_checkpoint(TRUNCATE)");
  } catch (const SQLite::Exception&) {
    // What was committed stays so; the next removal tries again.
  }
  connection_->wait_for_locks();
}

// Returns the error of the transaction, of which nothing is stored then. Each task has its own error.
std::optional<Error> Writer::commit(std::span<Task> tasks) {
  try {
    sync_commits(std::any_of(tasks.begin(), tasks.end(), [](auto& task) { return task.promise != Promise::fleeting; }));
    Query(*connection_, "BEGIN IMMEDIATE").run();
    for (Task& task : tasks) {
      task.error.reset();
      Query(*connection_, "SAVEPOINT task").run();
      if (!run_one(task)) Query(*connection_, "ROLLBACK TO task").run();
      Query(*connection_, "RELEASE task").run();
    }
    Result<Done> there = check_files();
    if (!there) {
      roll_back();
      return there.error();
    }
    Query(*connection_, "COMMIT").run();
    there = check_files();  // what is not in the files of their paths now must not be promised
    return there ? std::nullopt : std::optional(there.error());
  } catch (const SQLite::Exception& exception) {
    Error error = connection_->to_error(exception);
    roll_back();
    return error;
  }
}

Result<Done> Writer::check_files() {
  if (!files_) return Done{};
  Result<Done> there = files_->check();
  return there ? connection_->check_headers() : there;
}

void Writer::sync_commits(bool synced) {
  if (synced == synced_) return;
  connection_->execute(synced ? "PRAGMA synchronous = FULL" : "PRAGMA synchronous = NORMAL");
  synced_ = synced;
}

bool Writer::run_one(Task& task) {
  try {
    task.work(*connection_);
    return true;
  } catch (const SQLite::Exception& exception) {
    if (!concerns_one(exception)) throw;
    task.error = connection_->to_error(exception);
  } catch (const std::exception& exception) {
    task.error = Error{ErrorCode::internal, std::string("a write failed: ") + exception.what(), "", ""};
  }
  return false;
}

void Writer::roll_back() {
  try {
    if (connection_->in_transaction()) connection_->execute("ROLLBACK");
  } catch (const SQLite::Exception&) {
    // The next BEGIN fails until a rollback succeeds.
  }
}

}  // namespace meshgauge::server::store
