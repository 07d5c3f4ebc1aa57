// The parts of one upload, sent several at a time, because latency would leave the line idle between them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "engine/result.h"
#include "server/store/s3/client.h"

namespace meshgauge::server::store {

// Calls work() on so many threads, the caller's among them, and blocks until all have returned. Uses fewer threads when
// the system grants no more. Precondition: work() does not throw.
void at_once(std::size_t threads, const std::function<void()>& work);

// Sends one upload, by one call of send(). Holds one piece for each thread in memory, not whole parts.
class Parts {
 public:
  // `upload` was begun for `object`. Borrows its arguments.
  Parts(S3Client& client, const std::string& object, const std::string& upload, std::span<const std::byte> bytes,
        std::uint64_t part_bytes);

  // Returns the parts' ETags, in order. After an error no part is being sent, so the upload may be aborted. Errors:
  // those of S3Client::put_part().
  Result<std::vector<std::string>> send(std::size_t threads);

 private:
  struct Part {
    std::size_t index;
    std::span<const std::byte> bytes;
  };

  std::optional<Part> next();
  void send_some();
  void send_all_that_is_left();

  S3Client& client_;
  const std::string& object_;
  const std::string& upload_;
  const std::span<const std::byte> bytes_;
  const std::uint64_t part_bytes_;
  std::mutex mutex_;
  std::vector<std::string> etags_;
  std::size_t begun_ = 0;
  std::optional<Error> failed_;
};

}  // namespace meshgauge::server::store
