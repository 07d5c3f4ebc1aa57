#include "server/store/sqlite.h"

#include <algorithm>
#include <utility>

#include <sqlite3.h>

#include "server/store/data_folder.h"

namespace meshgauge::server::store {
namespace {

constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX;

}  // namespace

Connection::Connection(const std::string& path, Use use) : database_(path, kFlags, kBusyTimeoutMs) {
  execute("PRAGMA foreign_keys = ON");
  execute("PRAGMA temp_store = MEMORY");
  if (use == Use::read) {
    execute("PRAGMA query_only = ON");  // the file is open for writing: readers take part in the locks of the log
  } else {
    execute("PRAGMA auto_vacuum = INCREMENTAL");  // of a new database: room for the file system, on request
    execute("PRAGMA journal_mode = WAL");
    execute("PRAGMA synchronous = FULL");
    execute("PRAGMA journal_size_limit = 67108864");
  }
}

SQLite::Statement& Connection::prepared(const char* sql) {
  const auto found = statements_.find(sql);
  if (found != statements_.end()) return found->second;
  std::string numbered(sql);
  std::replace(numbered.begin(), numbered.end(), '$', '?');  // SQLite gives $2 the next number, and ?2 the second
  return statements_.emplace(sql, noted([&] { return SQLite::Statement(database_, numbered); })).first->second;
}

void Connection::execute(const char* sql) {
  noted([&] { database_.exec(sql); });
}

std::int64_t Connection::pragma(const char* name) {
  return noted([&] { return database_.execAndGet(std::string("PRAGMA ") + name).getInt64(); });
}

bool Connection::in_transaction() const { return sqlite3_get_autocommit(database_.getHandle()) == 0; }

Error Connection::to_error(const SQLite::Exception& exception) const {
  return store::to_error(exception, path(), system_error_);
}

Error to_error(const SQLite::Exception& exception, const std::string& path, int system_error) {
  const std::string what = "the database '" + path + "' ";
  const std::string text = std::string(": ") + exception.what();
  switch (exception.getErrorCode()) {
    case SQLITE_FULL:
      return {ErrorCode::storage_full, what + "has no room on its disk", "", ""};
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
      if (means_full(system_error)) return storage_error(system_error, what + "has no room");
      return {ErrorCode::storage_unavailable, what + "cannot be read or written" + text, "", ""};
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return {ErrorCode::storage_unavailable, what + "cannot be written" + text, "", ""};
    case SQLITE_NOMEM:
      return {ErrorCode::storage_unavailable, what + "cannot be used: the service is out of memory", "", ""};
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return {ErrorCode::storage_unavailable, what + "is locked by another program" + text, "", ""};
    case SQLITE_CORRUPT:
      if (system_error == EIO) return storage_error(system_error, what + "cannot be read");
      [[fallthrough]];
    case SQLITE_NOTADB:
      return {ErrorCode::internal, what + "is damaged" + text, "", ""};
    default:
      return {ErrorCode::internal, what + "failed" + text, "", ""};
  }
}

Query::~Query() {
  statement_.tryReset();  // returns the error of the run, which was thrown before
  statement_.clearBindings();
}

bool Query::next() {
  return connection_.noted([this] { return statement_.executeStep(); });
}

std::uint64_t Query::run() {
  while (next()) {
  }
  return static_cast<std::uint64_t>(statement_.getChanges());
}

std::optional<TimePoint> Query::time_if_any(int column) const {
  if (is_null(column)) return std::nullopt;
  return time(column);
}

std::unique_ptr<Connection> Readers::take() {
  std::unique_lock lock(mutex_);
  returned_.wait(lock, [this] { return taken_ < kMost; });
  ++taken_;
  if (idle_.empty()) return nullptr;
  std::unique_ptr<Connection> connection = std::move(idle_.back());
  idle_.pop_back();
  return connection;
}

void Readers::give_back(std::unique_ptr<Connection> connection) {
  {
    const std::lock_guard lock(mutex_);
    --taken_;
    if (connection) idle_.push_back(std::move(connection));
  }
  returned_.notify_one();
}

}  // namespace meshgauge::server::store
