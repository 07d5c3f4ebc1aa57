// SQLite over SQLiteCpp: a connection that keeps its prepared statements, a statement that is always reset, and a pool
// of connections that read. The first two throw SQLite::Exception; to_error() makes an Error of it. One thread at a
// time may use a connection.
#pragma once

#include <cerrno>
#include <concepts>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <SQLiteCpp/SQLiteCpp.h>

#include "server/store/job_store.h"
#include "server/store/open_files.h"
#include "server/store/sql.h"

namespace meshgauge::server::store {

class Query;

class Connection {
 public:
  enum class Use { write, read };

  // Joins the job of a row `item` of batch_items; all columns are NULL when the job is gone (rows.h).
  static constexpr Sql kJobOfItem{"LEFT JOIN jobs ON jobs.owner = item.owner AND jobs.id = item.job"};

  Connection(const std::string& path, Use use);

  // Prepares a statement and binds the values to its parameters $1, $2, ... Query::next() and run() execute it.
  template <class... Values>
  Query query(const char* sql, const Values&... values);

  SQLite::Statement& prepared(const char* sql);
  void execute(const char* sql);
  void wait_for_locks() { database_.setBusyTimeout(kBusyTimeoutMs); }  // as at the start
  std::int64_t pragma(const char* name);                               // precondition: its value is a number
  bool in_transaction() const;  // SQLite ends a transaction by itself after some errors

  // An Error (storage_damaged) if the database's file or its log no longer begins as one. Reads the files themselves: a
  // connection does not notice it while it has the pages in memory. Precondition: no other thread writes the database.
  Result<Done> check_headers();

  const std::string& path() const { return database_.getFilename(); }
  // Precondition of both: the newest call of this connection or its queries threw the exception. The first is for
  // callers, clients among them; the second names the path.
  Error to_error(const SQLite::Exception& exception) const;
  Error error_with_path(const SQLite::Exception& exception) const;

 private:
  friend class Query;

  // Calls it, and keeps errno, which has the reason of an exception.
  template <class Call>
  auto noted(Call call) {
    errno = 0;
    try {
      return call();
    } catch (const SQLite::Exception&) {
      system_error_ = errno;
      throw;
    }
  }

  static constexpr int kBusyTimeoutMs = 5000;  // no other process writes, but a backup may hold a lock

  SQLite::Database database_;
  int system_error_ = 0;
  std::map<std::string, SQLite::Statement, std::less<>> statements_;
};

// `system_error`: errno of the failed call; 0: unknown. `what`: the beginning of the message.
Error to_error(const SQLite::Exception& exception, int system_error = 0, const std::string& what = "the database");

std::string with_path(const std::string& path);  // "the database 'PATH'"

// One run of a prepared statement.
class Query {
 public:
  template <class... Values>
  Query(Connection& connection, const char* sql, const Values&... values)
      : connection_(connection), statement_(connection.prepared(sql)) {
    (bind(values), ...);
  }
  ~Query();
  Query(const Query&) = delete;
  Query& operator=(const Query&) = delete;

  bool next();          // moves to the next row; false: there is none
  std::uint64_t run();  // executes it to the end; returns the number of changed rows

  std::int64_t number(int column) const { return statement_.getColumn(column).getInt64(); }
  double real(int column) const { return statement_.getColumn(column).getDouble(); }
  std::string text(int column) const { return statement_.getColumn(column).getString(); }
  bool is_null(int column) const { return statement_.isColumnNull(column); }
  TimePoint time(int column) const { return TimePoint(std::chrono::milliseconds(number(column))); }
  std::optional<TimePoint> time_if_any(int column) const;

 private:
  void bind(const std::string& text) { statement_.bind(++bound_, text); }
  void bind(double real) { statement_.bind(++bound_, real); }
  void bind(TimePoint time) { bind(time.time_since_epoch().count()); }
  void bind(std::integral auto number) { statement_.bind(++bound_, static_cast<std::int64_t>(number)); }
  void bind(JobState state) { bind(static_cast<int>(state)); }
  template <class T>
  void bind(const std::optional<T>& value) {
    if (value) return bind(*value);
    statement_.bind(++bound_);
  }

  Connection& connection_;
  SQLite::Statement& statement_;
  int bound_ = 0;
};

template <class... Values>
Query Connection::query(const char* sql, const Values&... values) {
  return Query(*this, sql, values...);
}

// A pool of read-only connections. Each call of read() has one of its own. Thread safe.
class Readers {
 public:
  static constexpr std::size_t kMost = 8;  // further calls block

  // `files`: of the database, borrowed; null: they are not checked.
  explicit Readers(std::string path, const OpenFiles* files = nullptr) : path_(std::move(path)), files_(files) {}

  // Returns the value of work(Connection&), which may throw SQLite::Exception.
  template <class Work>
  auto read(Work work) -> Result<std::invoke_result_t<Work&, Connection&>> {
    std::unique_ptr<Connection> connection = take();
    const Return returned{*this, connection};
    return run(connection, work);
  }

  // The same on a new connection, beside the pool: finds what the next process would.
  template <class Work>
  auto read_anew(Work work) -> Result<std::invoke_result_t<Work&, Connection&>> {
    std::unique_ptr<Connection> connection;
    return run(connection, work);
  }

 private:
  // Opens a connection where there is none; not to other files, whose log the last connection to them would remove.
  template <class Work>
  auto run(std::unique_ptr<Connection>& connection, Work& work) -> Result<std::invoke_result_t<Work&, Connection&>> {
    try {
      if (!connection) {
        const Result<Done> there = files_ ? files_->check() : Done{};
        if (!there) return there.error();
        connection = std::make_unique<Connection>(path_, Connection::Use::read);
      }
      return work(*connection);
    } catch (const SQLite::Exception& exception) {
      if (connection) return connection->to_error(exception);
      return to_error(exception);
    }
  }

  struct Return {
    Readers& readers;
    std::unique_ptr<Connection>& connection;
    ~Return() { readers.give_back(std::move(connection)); }
  };

  std::unique_ptr<Connection> take();  // nullptr: open a new one
  void give_back(std::unique_ptr<Connection> connection);

  const std::string path_;
  const OpenFiles* const files_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::size_t taken_ = 0;
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace meshgauge::server::store
