#include "server/store/sqlite.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>
#include <utility>

#include <sqlite3.h>

#include "server/store/data_folder.h"

namespace meshgauge::server::store {
namespace {

constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_NOMUTEX;

constexpr std::string_view kFileHeader("SQLite format 3", 16);  // with its 0
constexpr std::string_view kLogHeader("\x37\x7f\x06");          // the next byte says the order of its checksums' bytes

// The file that a connection has open; null: none.
sqlite3_file* file_of(sqlite3* database, int which) {
  sqlite3_file* file = nullptr;
  if (sqlite3_file_control(database, "main", which, &file) != SQLITE_OK || !file || !file->pMethods) return nullptr;
  return file;
}

// Whether the file begins so. nullopt: it cannot be read now.
std::optional<bool> begins_with(sqlite3_file* file, std::string_view expected) {
  std::array<char, 16> bytes{};
  const int read = file->pMethods->xRead(file, bytes.data(), static_cast<int>(expected.size()), 0);
  if (read != SQLITE_OK && read != SQLITE_IOERR_SHORT_READ) return std::nullopt;
  return std::string_view(bytes.data(), expected.size()) == expected;
}

// The same, or empty: a log begins with its first entry.
std::optional<bool> is_log(sqlite3_file* file) {
  sqlite3_int64 size = 0;
  if (file->pMethods->xFileSize(file, &size) != SQLITE_OK) return std::nullopt;
  return size == 0 ? true : begins_with(file, kLogHeader);
}

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

Result<Done> Connection::check_headers() {
  sqlite3_file* const file = file_of(database_.getHandle(), SQLITE_FCNTL_FILE_POINTER);
  sqlite3_file* const log = file_of(database_.getHandle(), SQLITE_FCNTL_JOURNAL_POINTER);
  const std::optional<bool> is_sound = file ? begins_with(file, kFileHeader) : true;
  const std::optional<bool> has_log = log ? is_log(log) : true;
  if (!is_sound || !has_log) return Error{ErrorCode::storage_unavailable, "the database cannot be read", "", ""};
  if (*is_sound && *has_log) return Done{};
  return Error{ErrorCode::storage_damaged, "the database is damaged: another program has written to its files", "", ""};
}

Error Connection::to_error(const SQLite::Exception& exception) const {
  return store::to_error(exception, system_error_);
}

Error Connection::error_with_path(const SQLite::Exception& exception) const {
  return store::to_error(exception, system_error_, with_path(path()));
}

std::string with_path(const std::string& path) { return "the database '" + path + "'"; }

Error to_error(const SQLite::Exception& exception, int system_error, const std::string& database) {
  const std::string what = database + " ";
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
      return {ErrorCode::storage_damaged, what + "is damaged" + text, "", ""};
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
