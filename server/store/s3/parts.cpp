#include "server/store/s3/parts.h"

#include <algorithm>
#include <exception>
#include <thread>

#include "api/digest.h"

namespace meshgauge::server::store {

void at_once(std::size_t threads, const std::function<void()>& work) {
  std::vector<std::jthread> others;
  try {
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(work);
  } catch (const std::exception&) {
    // The threads that did start do all the work.
  }
  work();
}

Parts::Parts(S3Client& client, const std::string& object, const std::string& upload, std::span<const std::byte> bytes,
             std::uint64_t part_bytes)
    : client_(client),
      object_(object),
      upload_(upload),
      bytes_(bytes),
      part_bytes_(part_bytes),
      etags_((bytes.size() + part_bytes - 1) / part_bytes) {}

Result<std::vector<std::string>> Parts::send(std::size_t threads) {
  at_once(std::min(threads, etags_.size()), [this] { send_some(); });
  if (failed_) return *failed_;
  return std::move(etags_);
}

std::optional<Parts::Part> Parts::next() {
  const std::lock_guard lock(mutex_);
  if (failed_ || begun_ == etags_.size()) return std::nullopt;
  const std::uint64_t offset = begun_ * part_bytes_;
  return Part{begun_++, bytes_.subspan(offset, std::min(part_bytes_, bytes_.size() - offset))};
}

void Parts::send_all_that_is_left() {
  while (const std::optional<Part> part = next()) {
    const auto number = static_cast<unsigned>(part->index + 1);
    Result<std::string> etag = client_.put_part(object_, upload_, number, part->bytes, api::sha256_hex(part->bytes));
    const std::lock_guard lock(mutex_);
    if (etag) {
      etags_[part->index] = std::move(*etag);
    } else if (!failed_) {
      failed_ = etag.error();
    }
  }
}

void Parts::send_some() try {
  send_all_that_is_left();
} catch (const std::exception& error) {  // an exception must not leave a thread
  const std::lock_guard lock(mutex_);
  if (!failed_) failed_ = Error{ErrorCode::internal, error.what(), "", ""};
}

}  // namespace meshgauge::server::store
