// The operations of S3 that blobs need, on the objects of one bucket. Thread safe.
//
// What may pass by itself (no connection, 5xx, SlowDown, a body that was cut off) is tried again, at growing intervals
// and for a limited time. Each operation has the same effect however often the server carries it out.
//
// Errors: storage_full (the server has no room), storage_unavailable (unreachable, overloaded, or it refuses us), and
// internal (it does not understand us). Their texts say what the server called its refusal, and may be told to
// anybody; that it was not to be reached, and why, is reported.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "net/http_client.h"
#include "server/store/byte_source.h"
#include "server/store/outage.h"
#include "server/store/s3/answers.h"
#include "server/store/s3/settings.h"

namespace meshgauge::server::store {

struct S3Limits {
  std::chrono::milliseconds connect{5'000};
  std::chrono::seconds stall{30};     // without a byte, in either direction, of a large body
  std::chrono::seconds small{60};     // of an exchange without a large body
  std::chrono::seconds patient{600};  // of one that the server may think about for minutes, without a byte
  unsigned attempts = 6;
  std::chrono::milliseconds first_pause{100};  // doubled each time, and a random half of it taken off
  std::chrono::milliseconds longest_pause{5'000};
  std::chrono::seconds give_up{60};  // no attempt but the second begins later than that
};

struct S3Object {
  std::uint64_t size = 0;
  std::string sha256;                // base64, as the server computed it; empty: it did not; "...-N": of N parts'
  std::string etag;                  // another one: other bytes, or bytes that were stored in another way
  std::chrono::milliseconds age{0};  // by the server's clock, to a second
};

std::string base64_of_hex(const std::string& hex);  // 64 digits

class S3Client {
 public:
  using Take = std::function<Result<Done>(std::span<const std::byte> piece)>;

  S3Client(S3Settings settings, S3Limits limits, Report report = {});

  // Keys are those of the bucket: the settings' prefix is not added.
  Result<std::optional<S3Object>> head(const std::string& key);
  // `sha256` is the body's, in hex: the server refuses other bytes.
  Result<Done> put(const std::string& key, const ByteSource& body, const std::string& sha256);
  // false: there is none. A connection that is lost is followed by a request for the rest.
  Result<bool> get(const std::string& key, const Take& take);
  // Makes it young; false: there is none. At most 5 GiB.
  Result<bool> copy_onto_itself(const std::string& key);
  Result<Done> remove(const std::string& key);                                 // also when there is none
  Result<ListPage> list(const std::string& prefix, const std::string& token);  // "" for the first page

  Result<std::string> begin_upload(const std::string& key);
  Result<std::string> put_part(const std::string& key, const std::string& upload, unsigned number,
                               const ByteSource& body, const std::string& sha256);  // its ETag
  // false: there is no such upload. An attempt whose answer was lost has completed it, or somebody has aborted it.
  Result<bool> complete_upload(const std::string& key, const std::string& upload,
                               const std::vector<std::string>& etags);
  Result<Done> abort_upload(const std::string& key, const std::string& upload);  // also when there is none
  Result<UploadsPage> list_uploads(const std::string& prefix, const std::string& after_key,
                                   const std::string& after_id);

  const S3Settings& settings() const { return settings_; }

 private:
  using TakeAnswer = std::function<Result<Done>(int status, std::span<const std::byte> piece)>;
  struct Call;
  struct Ending;

  Ending perform(const Call& call);
  Ending perform_patiently(const Call& call);
  net::HttpAnswer attempt(const Call& call, std::uint64_t received, const TakeAnswer& take);

  const S3Settings settings_;
  const S3Limits limits_;
  const std::string host_;       // as in the header Host
  const std::string base_path_;  // "/" or "/BUCKET/"
  net::HttpClient http_;
  Outage outage_;
};

}  // namespace meshgauge::server::store
