#include "server/store/s3/s3_blobs.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <limits>
#include <mutex>
#include <optional>
#include <system_error>
#include <thread>
#include <unordered_set>
#include <vector>

#include "api/base/digest.h"

namespace meshgauge::server::store {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr std::size_t kHash = 64;
constexpr std::size_t kName = kHash + 1 + 2 + 1 + kHash;

std::string owner_in(const std::string& name) { return name.substr(0, kHash); }
std::string id_in(const std::string& name) { return name.substr(name.size() - kHash); }

// Whether blob_name() makes such names: other objects of the bucket are not ours.
bool is_blob_name(const std::string& name) {
  if (name.size() != kName) return false;
  const std::string owner = owner_in(name);
  const std::string id = id_in(name);
  return is_blob_id(owner) && is_blob_id(id) && name == owner + "/" + id.substr(0, 2) + "/" + id;
}

// The time of modification and the server's clock may both be cut to whole seconds, so the age is known to one second.
bool is_surely_older(milliseconds age, seconds limit) { return limit == seconds(0) || age - seconds(1) >= limit; }

// By the checksum of the server. It has none of these bytes for an upload in parts: then neither is known.
bool is_known_sound(const S3Object& found, const std::string& id, std::uint64_t size) {
  return found.size == size && found.sha256 == base64_of_hex(id);
}
bool is_known_damaged(const S3Object& found, const std::string& id, std::uint64_t size) {
  if (found.size != size) return true;
  return !found.sha256.empty() && found.sha256.find('-') == std::string::npos && found.sha256 != base64_of_hex(id);
}

// Calls work() on so many threads, the caller's among them, and blocks until all have returned. Uses fewer threads when
// the system grants no more. Precondition: work() does not throw.
void at_once(std::size_t threads, const std::function<void()>& work) {
  std::vector<std::jthread> others;
  try {
    for (std::size_t i = 1; i < threads; ++i) others.emplace_back(work);
  } catch (const std::exception&) {
    // The threads that did start do all the work.
  }
  work();
}

// The parts of one upload, sent by one call of send(): several at a time, because latency would leave the line idle
// between them. Holds one piece for each thread in memory, not whole parts.
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

}  // namespace

OwnerSums::~OwnerSums() {
  std::vector<std::future<void>> refreshes;
  {
    const std::lock_guard lock(mutex_);
    for (auto& [owner, sum] : sums_) refreshes.push_back(std::move(sum.refresh));
  }
  for (const std::future<void>& refresh : refreshes) {
    if (refresh.valid()) refresh.wait();  // it writes to sums_, which must outlive it
  }
}

Result<std::uint64_t> OwnerSums::of(const std::string& owner) {
  std::unique_lock lock(mutex_);
  Sum& sum = sums_[owner];
  weighed_.wait(lock, [&] { return sum.known || !sum.weighing; });
  const bool due = !sum.weighing && Clock::now() >= sum.good_until;
  if (sum.known && !due) return sum.bytes;
  sum.meanwhile = 0;
  if (sum.known) {
    try {
      sum.refresh = std::async(std::launch::async, [this, owner] { static_cast<void>(weigh(owner)); });
      sum.weighing = true;
    } catch (const std::system_error&) {  // no thread is to be had: the next call tries again
    }
    return sum.bytes;
  }
  sum.weighing = true;
  lock.unlock();
  return weigh(owner);
}

// Callers that wait for the listing must be woken.
Result<std::uint64_t> OwnerSums::weighed(const std::string& owner) const try {
  return weigh_(owner);
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, error.what(), "", ""};
}

Result<std::uint64_t> OwnerSums::weigh(const std::string& owner) {
  const Clock::time_point begin = Clock::now();
  const Result<std::uint64_t> found = weighed(owner);
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.weighing = false;
  sum.good_until = Clock::now() + std::max<Clock::duration>(age_, kIdle * (Clock::now() - begin));
  if (found) {
    sum.known = true;
    sum.bytes = *found + sum.meanwhile;
  }
  weighed_.notify_all();
  if (!found) return found.error();
  return sum.bytes;
}

void OwnerSums::add(const std::string& owner, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.bytes += bytes;
  sum.meanwhile += bytes;
}

void OwnerSums::remove(const std::string& owner, std::uint64_t bytes) {
  const std::lock_guard lock(mutex_);
  Sum& sum = sums_[owner];
  sum.bytes -= std::min(bytes, sum.bytes);
}

S3Blobs::S3Blobs(S3Settings settings, S3BlobOptions options, S3Limits limits, Report report)
    : options_(options),
      client_(std::move(settings), limits, std::move(report)),
      root_(client_.settings().prefix.empty() ? "" : client_.settings().prefix + "/"),
      sums_([this](const std::string& owner) { return weigh(owner); }, options.sum_age) {}

Result<BlobPut> S3Blobs::put(const BlobKey& key, std::span<const std::byte> bytes) {
  if (bytes.size() > kMaxS3Blob)
    return Error{ErrorCode::internal, "the mesh is too large for S3: at most 5 GiB", "", ""};
  if (api::sha256_hex(bytes) != key.id) return BlobPut::other_digest;
  const std::string object = object_of(blob_name(key));
  const Result<std::optional<S3Object>> there = client_.head(object);
  if (!there) return there.error();
  const std::optional<S3Object>& found = *there;
  if (found && is_known_sound(*found, key.id, bytes.size())) {
    const Result<bool> renewed = renew(object, *found);
    if (!renewed) return renewed.error();
    if (*renewed) return BlobPut::existed;
  }
  // Sends the bytes also when the server has no checksum of a stored object: reading it would cost as much.
  if (const Result<Done> sent = send(key, bytes, found ? found->etag : ""); !sent) return sent.error();
  if (found) sums_.remove(owner_in(blob_name(key)), found->size);
  sums_.add(owner_in(blob_name(key)), bytes.size());
  return found && !is_known_damaged(*found, key.id, bytes.size()) ? BlobPut::existed : BlobPut::created;
}

Result<Done> S3Blobs::send(const BlobKey& key, std::span<const std::byte> bytes, const std::string& etag_before) {
  const std::string object = object_of(blob_name(key));
  if (bytes.size() < options_.in_parts_from) return client_.put(object, bytes, key.id);
  const Result<std::string> upload = client_.begin_upload(object);
  if (!upload) return upload.error();
  const Result<bool> completed = send_parts(key, *upload, bytes);
  if (completed) return check_completed(object, bytes.size(), *completed ? "" : etag_before);
  // If this fails, abort_abandoned() does it a day later.
  static_cast<void>(client_.abort_upload(object, *upload));
  return completed.error();
}

// Returns as complete_upload() does.
Result<bool> S3Blobs::send_parts(const BlobKey& key, const std::string& upload, std::span<const std::byte> bytes) {
  const std::string object = object_of(blob_name(key));
  const auto etags = Parts(client_, object, upload, bytes, options_.part_bytes).send(options_.parts_at_once);
  if (!etags) return etags.error();
  return client_.complete_upload(object, upload, *etags);
}

// `not_etag`: of the object that the upload was to replace, in case it was aborted; "": any ETag.
Result<Done> S3Blobs::check_completed(const std::string& object, std::uint64_t size, const std::string& not_etag) {
  const Result<std::optional<S3Object>> there = client_.head(object);
  if (!there) return there.error();
  if (!*there || (**there).size != size || (!not_etag.empty() && (**there).etag == not_etag)) {
    return Error{ErrorCode::storage_unavailable, "S3 has not kept an upload that it completed", "", ""};
  }
  // The object's time of modification is the begin of the upload, so it is renewed.
  const Result<bool> renewed = renew(object, **there);
  if (!renewed) return renewed.error();
  return Done{};
}

Result<bool> S3Blobs::fetch(const BlobKey& key, const Take& take) {
  return client_.get(object_of(blob_name(key)), take);
}

Result<bool> S3Blobs::exists(const BlobKey& key) {
  const Result<std::optional<S3Object>> there = client_.head(object_of(blob_name(key)));
  if (!there) return there.error();
  return there->has_value();
}

Result<bool> S3Blobs::renew(const BlobKey& key) {
  const std::string object = object_of(blob_name(key));
  const Result<std::optional<S3Object>> there = client_.head(object);
  if (!there) return there.error();
  if (!*there) return false;
  return renew(object, **there);
}

Result<bool> S3Blobs::renew(const std::string& object, const S3Object& found) {
  if (found.age + seconds(1) < options_.young) return true;
  return client_.copy_onto_itself(object);
}

Result<bool> S3Blobs::remove(const BlobKey& key) {
  const std::string name = blob_name(key);
  const Result<std::optional<S3Object>> there = client_.head(object_of(name));
  if (!there) return there.error();
  if (!*there) return false;
  return remove_found(name, **there);
}

Result<bool> S3Blobs::remove_found(const std::string& name, const S3Object& found) {
  sums_.remove(owner_in(name), found.size);
  const Result<Done> removed = client_.remove(object_of(name));
  if (removed) return true;
  sums_.add(owner_in(name), found.size);
  return removed.error();
}

// Calls visit(objects) with the unused ones of each page, until that returns an error.
template <class Visit>
Result<Done> S3Blobs::for_each_unused(std::span<const BlobKey> used, seconds limit, Visit visit) {
  std::unordered_set<std::string> kept;
  for (const BlobKey& key : used) kept.insert(blob_name(key));
  std::string token;
  do {
    const Result<ListPage> page = client_.list(root_, token);
    if (!page) return page.error();
    std::vector<ListedObject> unused;
    for (const ListedObject& object : page->objects) {
      const std::string name = object.key.substr(std::min(root_.size(), object.key.size()));
      const auto age = page->now - object.modified;
      if (is_blob_name(name) && !kept.contains(name) && is_surely_older(age, limit)) unused.push_back(object);
    }
    const Result<Done> visited = visit(unused);
    if (!visited) return visited;
    token = page->next;
  } while (!token.empty());
  return Done{};
}

Result<UnusedBlobs> S3Blobs::count_unused(std::span<const BlobKey> used, seconds older_than) {
  UnusedBlobs unused;
  const Result<Done> counted =
      for_each_unused(used, older_than + options_.young, [&](const std::vector<ListedObject>& objects) {
        unused.number += objects.size();
        for (const ListedObject& object : objects) unused.oldest = std::min(unused.oldest, object.modified);
        return Result<Done>(Done{});
      });
  if (!counted) return counted.error();
  return unused;
}

Result<std::uint64_t> S3Blobs::remove_unused(std::span<const BlobKey> used, seconds older_than,
                                             Reservations& reservations) {
  const seconds limit = older_than + options_.young;
  std::uint64_t removed = 0;
  const Result<Done> swept =
      for_each_unused(used, limit, [&](const std::vector<ListedObject>& objects) -> Result<Done> {
        std::vector<std::string> names;
        for (const ListedObject& object : objects) names.push_back(object.key.substr(root_.size()));
        const Result<std::uint64_t> some = remove_listed(names, limit, reservations);
        if (!some) return some.error();
        removed += *some;
        return Done{};
      });
  if (!swept) return swept.error();
  if (const Result<Done> aborted = abort_abandoned(); !aborted) return aborted.error();
  return removed;
}

// Reads the object's age again when no reservation can begin any more: it may have been renewed since it was listed.
Result<bool> S3Blobs::remove_if_old(const std::string& name, seconds older_than, Reservations& reservations) try {
  return reservations.unless_held(name, [&]() -> Result<bool> {
    const Result<std::optional<S3Object>> there = client_.head(object_of(name));
    if (!there) return there.error();
    if (!*there || !is_surely_older((**there).age, older_than)) return false;
    return remove_found(name, **there);
  });
} catch (const std::exception& error) {
  return Error{ErrorCode::internal, error.what(), "", ""};  // an exception must not leave a thread
}

// Removes several at once, until the first error.
Result<std::uint64_t> S3Blobs::remove_listed(const std::vector<std::string>& names, seconds older_than,
                                             Reservations& reservations) {
  std::atomic<std::size_t> next{0};
  std::atomic<std::uint64_t> removed{0};
  std::mutex mutex;
  std::optional<Error> failed;
  const auto remove_some = [&] {
    for (std::size_t i = next++; i < names.size(); i = next++) {
      const Result<bool> gone = remove_if_old(names[i], older_than, reservations);
      if (gone && *gone) ++removed;
      if (gone) continue;
      next = names.size();
      const std::lock_guard lock(mutex);
      failed = gone.error();
    }
  };
  at_once(std::min<std::size_t>(options_.removals_at_once, names.size()), remove_some);
  if (failed) return *failed;
  return removed.load();
}

Result<Done> S3Blobs::abort_abandoned() {
  UploadsPage page;
  do {
    Result<UploadsPage> next = client_.list_uploads(root_, page.next_key, page.next_id);
    if (!next) return next.error();
    if (!next->next_key.empty() && next->next_key == page.next_key && next->next_id == page.next_id) {
      return Error{ErrorCode::storage_unavailable, "S3 returned the same page of a list twice", "", ""};
    }
    page = std::move(*next);
    for (const ListedUpload& upload : page.uploads) {
      const bool ours = is_blob_name(upload.key.substr(std::min(root_.size(), upload.key.size())));
      if (!ours || !is_surely_older(page.now - upload.begun, options_.abandoned)) continue;
      const Result<Done> aborted = client_.abort_upload(upload.key, upload.id);
      if (!aborted) return aborted;
    }
  } while (!page.next_key.empty());
  return Done{};
}

Result<std::uint64_t> S3Blobs::stored_bytes(const std::string& owner) {
  return sums_.of(owner_in(blob_name({owner, ""})));
}

Result<std::uint64_t> S3Blobs::weigh(const std::string& owner) {
  std::uint64_t bytes = 0;
  std::string token;
  do {
    const Result<ListPage> page = client_.list(root_ + owner + "/", token);
    if (!page) return page.error();
    for (const ListedObject& object : page->objects) bytes += object.size;
    token = page->next;
  } while (!token.empty());
  return bytes;
}

Result<std::uint64_t> S3Blobs::free_bytes() { return std::numeric_limits<std::uint64_t>::max(); }

Result<Done> S3Blobs::check() {
  static constexpr std::array<std::byte, 4096> kBlock{};
  static const std::string kDigest = api::sha256_hex(kBlock);
  return client_.put(object_of("check"), kBlock, kDigest);
}

}  // namespace meshgauge::server::store
