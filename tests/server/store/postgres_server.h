// A PostgreSQL server for the tests alone: in a temporary folder, on a socket there, gone with the object.
#pragma once

#include <sys/types.h>

#include <string>

namespace meshgauge::server::store {

class PostgresServer {
 public:
  // Where initdb and postgres are: $MESHGAUGE_POSTGRES, or the newest of Debian's. Empty: not installed.
  static std::string programs();
  // The one of this run of the program, started when it is first asked for.
  static PostgresServer& shared();

  PostgresServer();
  ~PostgresServer();
  PostgresServer(const PostgresServer&) = delete;
  PostgresServer& operator=(const PostgresServer&) = delete;

  void start();
  void stop();  // fast: connections are closed
  void kill();  // as kill -9 and a machine that comes back

  // A connection string of a new database, with the schema or empty.
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
