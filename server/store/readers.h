// A pool of read-only connections. Each call of read() has one of its own. Thread safe.
#pragma once

#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/store/sqlite.h"

namespace meshgauge::server::store {

class Readers {
 public:
  static constexpr std::size_t kMost = 8;  // further calls block

  explicit Readers(std::string path) : path_(std::move(path)) {}

  // Returns the value of work(Connection&), which may throw SQLite::Exception.
  template <class Work>
  auto read(Work work) -> Result<std::invoke_result_t<Work&, Connection&>> {
    std::unique_ptr<Connection> connection = take();
    const Return returned{*this, connection};
    try {
      if (!connection) connection = std::make_unique<Connection>(path_, Connection::Use::read);
      return work(*connection);
    } catch (const SQLite::Exception& exception) {
      if (connection) return connection->to_error(exception);
      return to_error(exception, path_);
    }
  }

 private:
  struct Return {
    Readers& readers;
    std::unique_ptr<Connection>& connection;
    ~Return() { readers.give_back(std::move(connection)); }
  };

  std::unique_ptr<Connection> take();  // nullptr: open a new one
  void give_back(std::unique_ptr<Connection> connection);

  const std::string path_;
  std::mutex mutex_;
  std::condition_variable returned_;
  std::size_t taken_ = 0;
  std::vector<std::unique_ptr<Connection>> idle_;
};

}  // namespace meshgauge::server::store
