// A PostgreSQL server for the tests alone: in a temporary folder, on a socket there; the destructor removes it.
#pragma once

#include <sys/types.h>

#include <string>

namespace meshgauge::server::store {

class PostgresServer {
 public:
  // The folder of initdb and postgres: $MESHGAUGE_POSTGRES, or Debian's newest. Empty: not installed.
  static std::string programs();
  // The server of this run, started at the first call.
  static PostgresServer& shared();

  PostgresServer();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  void start();
  void stop();  // fast: connections are closed
  void kill();  // kill -9, and a restart

  // Creates a database, with the schema or empty; returns its connection string.
  std::string new_database();
  std::string new_empty_database();
  std::string connection_string(const std::string& database) const;
  void execute(const std::string& sql);  // in the database "postgres"
  void drop(const std::string& connection_string);

 private:
  const std::string folder_;
  std::string programs_;
  pid_t process_ = -1;
  unsigned databases_ = 0;
  bool has_template_ = false;
};

}  // namespace meshgauge::server::store
