// What the store needs of libpq: a connection that waits no longer than it is told, keeps its prepared statements, and
// throws a PgFailure that says whether to try again. One thread at a time uses a connection.
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>

#include "server/store/postgres/values.h"
#include "server/store/sql.h"

struct pg_conn;  // libpq's PGconn

namespace meshgauge::server::store {

using SteadyTime = std::chrono::steady_clock::time_point;

struct PgFailure {
  std::string state;  // SQLSTATE; empty: the connection itself failed
  std::string message;
  bool connection_lost = false;  // or of no more use: another one is needed
  bool may_pass = false;         // the same statement may succeed if it is sent again
};

// As a caller of the store is told.
Error to_error(const PgFailure& failure);

class PgConnection {
 public:
  // Of a row `item` of batch_items: its job, all NULL where it is gone (rows.h). OFFSET 0, here and in other
  // statements, makes PostgreSQL find the rows one by one by the index of their keys, whatever it estimates of their
  // number.
  static constexpr Sql kJobOfItem{R"sql(
      LEFT JOIN LATERAL (SELECT * FROM jobs WHERE owner = item.owner AND id = item.job OFFSET 0) AS jobs ON true)sql"};

  // Blocks for the connection string's connect_timeout for each host, 2 s by default. The server is one that can be
  // written to.
  static std::unique_ptr<PgConnection> open(const std::string& database);

  // Until when what follows may take; beyond it the connection is lost. At first without an end.
  void set_deadline(SteadyTime deadline) { deadline_ = deadline; }

  // One statement, prepared when it first comes. The text must live as long as the program.
  template <class... Values>
  PgRows query(const char* sql, const Values&... values) {
    return query(sql, PgValues(values...));
  }
  PgRows query(const char* sql, const PgValues& values);
  PgRows execute(const std::string& sql);  // one or several statements without parameters; the last one's rows

  // All that was committed before, by whomever, is durable afterwards. For a caller who finds done what it was to do:
  // its own commit writes nothing, so it waits for no disk and no standby, and that other one may not have waited.
  // In a transaction: when that is committed.
  void put_barrier() { query("SELECT pg_logical_emit_message(true, 'meshgauge', '')"); }

  bool usable() const;
  bool in_transaction() const;
  int socket() const;

  // Notifications that have arrived; reads what there is without waiting, and so sees that a connection has ended.
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
  bool unreplicated_ = false;  // a commit was told to wait no longer for another server
  std::unordered_map<std::string_view, std::string> names_;
};

// Rolled back unless it was committed.
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
