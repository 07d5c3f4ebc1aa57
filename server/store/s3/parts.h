// The parts of one upload, sent several at a time: over a way with latency one after another leaves most of it idle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "api/digest.h"
#include "engine/result.h"
#include "server/store/byte_source.h"
#include "server/store/s3/client.h"

namespace meshgauge::server::store {

// Calls work() in so many threads, one of which is the caller's, and waits for all; in fewer when the system gives no
// more. work() must throw nothing.
void at_once(std::size_t threads, const std::function<void()>& work);

// Of one call of send(). What it holds in memory is each thread's piece, not its part.
class Parts {
 public:
  // `upload` is one that was begun for `object`; all must outlive this.
  Parts(S3Client& client, const std::string& object, const std::string& upload, const ByteSource& bytes,
        std::uint64_t part_bytes);

  // Their ETags, in order. After an error nothing is being sent any more, so the upload may be aborted. Errors: as
  // S3Client::put_part(), and internal when the bytes are not (any more) those of the SHA-256 `id`.
  Result<std::vector<std::string>> send(std::size_t threads, const std::string& id);

 private:
  struct Part {
    std::size_t index;
    ByteSource bytes;
    std::string sha256;
  };

  std::optional<Part> next();
  void send_some();
  void send_all_that_is_left();

  S3Client& client_;
  const std::string& object_;
  const std::string& upload_;
  const ByteSource& bytes_;
  const std::uint64_t part_bytes_;
  std::mutex mutex_;
  api::Sha256 whole_;
  std::vector<std::string> etags_;
  std::size_t begun_ = 0;
  std::optional<Error> failed_;
};

}  // namespace meshgauge::server::store
