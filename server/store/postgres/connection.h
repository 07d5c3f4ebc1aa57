// PostgreSQL over libpq: a connection that blocks no longer than its deadline, keeps its prepared statements, and
// throws a PgFailure that says whether to try again. One thread at a time may use a connection.
//
// Values travel in PostgreSQL's binary formats. Text is `bytea`: any bytes come back unchanged, also NUL and bytes that
// are not UTF-8, and are compared byte by byte.
#pragma once

#include <chrono>
#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "server/store/job_store.h"
#include "server/store/sql.h"

struct pg_conn;    // libpq's PGconn
struct pg_result;  // libpq's PGresult

namespace meshgauge::server::store {

// The parameters $1, $2, ... of one statement. Real numbers are sent as float8, integers as int8.
class PgValues {
 public:
  template <class... Values>
  explicit PgValues(const Values&... values) {
    (add(values), ...);
  }

  int size() const { return static_cast<int>(types_.size()); }
  const unsigned* types() const { return types_.data(); }
  // Valid until this object changes.
  std::vector<const char*> pointers() const;
  std::vector<int> lengths() const;

 private:
  void add(std::string_view text);
  void add(const std::string& text) { add(std::string_view(text)); }
  void add(const char* text) { add(std::string_view(text)); }
  void add(std::span<const std::byte> bytes);
  void add(double real);
  void add(bool flag);
  void add(std::int64_t number);
  void add(std::integral auto number) { add(static_cast<std::int64_t>(number)); }
  void add(JobState state) { add(static_cast<std::int64_t>(state)); }
  void add(TimePoint time) { add(static_cast<std::int64_t>(time.time_since_epoch().count())); }
  void add(const std::vector<std::string>& texts);
  void add(const std::vector<std::optional<std::string>>& texts);
  void add(const std::vector<std::int64_t>& numbers);
  void add(const std::vector<std::optional<std::int64_t>>& numbers);
  void add(const std::vector<std::optional<double>>& reals);
  template <class T>
  void add(const std::optional<T>& value) {
    if (value) return add(*value);
    add(T{});
    values_.back().reset();
  }
  void add(unsigned type, std::string bytes);

  std::vector<unsigned> types_;
  std::vector<std::optional<std::string>> values_;
};

// The rows that a statement returned; next() moves to the first one.
class PgRows {
 public:
  explicit PgRows(pg_result* result) : result_(result) {}

  bool next() { return ++row_ < size(); }
  int size() const;
  std::uint64_t changed() const;  // number of rows that an INSERT, UPDATE or DELETE changed

  bool is_null(int column) const;
  std::int64_t number(int column) const;  // of any integer type, or a boolean
  double real(int column) const;
  std::string text(int column) const;
  std::string_view bytes(int column) const;  // valid while this object lives
  TimePoint time(int column) const { return TimePoint(std::chrono::milliseconds(number(column))); }
  std::optional<TimePoint> time_if_any(int column) const;

 private:
  struct Cleared {
    void operator()(pg_result* result) const;
  };
  std::unique_ptr<pg_result, Cleared> result_;
  int row_ = -1;
};

using SteadyTime = std::chrono::steady_clock::time_point;

struct PgFailure {
  std::string state;  // SQLSTATE; empty: the connection itself failed
  std::string message;
  bool connection_lost = false;  // lost or unusable: another connection is needed
  bool may_pass = false;         // the same statement may succeed if it is sent again
};

// The error for callers of the store.
Error to_error(const PgFailure& failure);

class PgConnection {
 public:
  // Joins the job of a row `item` of batch_items; all columns are NULL when the job is gone (rows.h). OFFSET 0, here
  // and in other statements, makes PostgreSQL find the rows one by one by the index of their keys, whatever number of
  // rows it estimates.
  static constexpr Sql kJobOfItem{R"sql(
      LEFT JOIN LATERAL (SELECT * FROM jobs WHERE owner = item.owner AND id = item.job OFFSET 0) AS jobs ON true)sql"};

  // Connects to a server that can be written to. Blocks up to the connection string's connect_timeout for each host, 2
  // s by default.
  static std::unique_ptr<PgConnection> open(const std::string& database);

  // Calls that pass the deadline lose the connection. There is none at first.
  void set_deadline(SteadyTime deadline) { deadline_ = deadline; }

  // Executes one statement, prepared at its first use. Precondition: `sql` lives as long as the program.
  template <class... Values>
  PgRows query(const char* sql, const Values&... values) {
    return query(sql, PgValues(values...));
  }
  PgRows query(const char* sql, const PgValues& values);
  PgRows execute(const std::string& sql);  // one or several statements without parameters; returns the rows of the last

  // Makes all earlier commits durable, of other connections, too; in a transaction when that is committed. For a caller
  // that finds its work done: its own commit writes nothing, so it waits for no disk and no standby, and the commit
  // that did the work may not have waited.
  void put_barrier() { query("SELECT pg_logical_emit_message(true, 'meshgauge', '')"); }

  bool usable() const;
  bool in_transaction() const;
  int socket() const;

  // Returns the notifications that have arrived, without blocking. Notices that the connection has ended.
  struct Notification {
    std::string channel, payload;
  };
  std::vector<Notification> notifications();

 private:
  struct Closed {
    void operator()(pg_conn* connection) const;
  };

  explicit PgConnection(pg_conn* connection);

  PgRows finish(bool sent);
  void read_all();
  const std::string& prepared(const char* sql, const PgValues& values);
  void wait(short events);
  [[noreturn]] void lost(const std::string& why);

  std::unique_ptr<pg_conn, Closed> connection_;
  SteadyTime deadline_ = SteadyTime::max();
  SteadyTime plans_until_{};
  bool lost_ = false;
  bool unreplicated_ = false;  // a commit stopped waiting for the standby
  std::unordered_map<std::string_view, std::string> names_;
  std::uint64_t prepared_ = 0;  // statements, also those that failed
};

// A transaction; rolled back by the destructor unless commit() was called.
class PgTransaction {
 public:
  explicit PgTransaction(PgConnection& connection) : connection_(connection) { connection.execute("BEGIN"); }
  PgTransaction(const PgTransaction&) = delete;
  PgTransaction& operator=(const PgTransaction&) = delete;
  ~PgTransaction();
  void commit();

 private:
  PgConnection& connection_;
};

}  // namespace meshgauge::server::store
