// The operations of S3 that blobs need, on the objects of one bucket, and the reading of its answers. Thread safe.
//
// Calls block for the network. A failure that may pass (no connection, 5xx, SlowDown, a body that was cut off) is tried
// again, at growing intervals and for a limited time; each operation has the same effect however often it is carried
// out.
//
// Errors: storage_full (the server has no room), storage_unavailable (unreachable, overloaded, or it refuses access),
// and internal (it rejects the request as invalid). Their messages have the server's code and may be shown to clients;
// why a server is unreachable goes to the report.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/result.h"
#include "net/http_client.h"
#include "server/store/outage.h"
#include "server/store/s3/settings.h"

namespace meshgauge::server::store {

using S3Time = std::chrono::sys_time<std::chrono::milliseconds>;

struct ListedObject {
  std::string key;
  std::uint64_t size = 0;
  S3Time modified{};
};

struct ListPage {
  std::vector<ListedObject> objects;
  std::string next;  // the token of the next page; empty: this is the last page
  S3Time now{};      // when the server answered, by its clock, to a second
};

struct ListedUpload {
  std::string key;
  std::string id;
  S3Time begun{};
};

struct UploadsPage {
  std::vector<ListedUpload> uploads;
  std::string next_key, next_id;  // both empty: this is the last page
  S3Time now{};
};

// Parse S3's answers, in XML and in headers. The text is not trusted: any other form than the expected one is an error.
Result<ListPage> list_page_of(const net::HttpAnswer& answer);
Result<UploadsPage> uploads_page_of(const net::HttpAnswer& answer);
Result<std::string> upload_id_of(const net::HttpAnswer& answer);
std::string list_of_parts(const std::vector<std::string>& etags);  // the body that completes an upload of many parts

// Returns the code of a refusal ("SlowDown"), or "". A refusal may come with a status of success, when a long operation
// fails after the head was sent. The code has letters and digits alone, so it may be shown to clients.
std::string error_code_of(const net::HttpAnswer& answer);

// "2026-11-22T08:30:00.000Z", and as in headers: "Sun, 22 Nov 2026 08:30:00 GMT".
Result<S3Time> time_of_xml(const std::string& text);
Result<S3Time> time_of_header(const std::string& text);

struct S3Limits {
  std::chrono::milliseconds connect{5'000};
  std::chrono::seconds stall{30};     // without a byte of a large body, in either direction
  std::chrono::seconds small{60};     // for an exchange without a large body
  std::chrono::seconds patient{600};  // for an operation that may take minutes without a byte
  unsigned attempts = 6;
  std::chrono::milliseconds first_pause{100};  // doubled each time, less a random part of up to a half
  std::chrono::milliseconds longest_pause{5'000};
  std::chrono::seconds give_up{60};  // no attempt after the second begins later
};

struct S3Object {
  std::uint64_t size = 0;
  std::string sha256;                // base64, computed by the server; empty: none; "...-N": over N parts
  std::string etag;                  // changes with the bytes, and with the way of their upload
  std::chrono::milliseconds age{0};  // by the server's clock, to a second
};

std::string base64_of_hex(const std::string& hex);  // 64 digits

class S3Client {
 public:
  using Take = std::function<Result<Done>(std::span<const std::byte> piece)>;

  S3Client(S3Settings settings, S3Limits limits, Report report = {});

  // Keys are full names in the bucket, with the prefix. nullopt: no such object.
  Result<std::optional<S3Object>> head(const std::string& key);
  // `sha256`: of the body, in hex; the server refuses other bytes.
  Result<Done> put(const std::string& key, std::span<const std::byte> body, const std::string& sha256);
  // Passes the bytes to `take`; false: no such object. After a lost connection it requests the rest.
  Result<bool> get(const std::string& key, const Take& take);
  // Sets the time of modification to now; false: no such object. At most 5 GiB.
  Result<bool> copy_onto_itself(const std::string& key);
  Result<Done> remove(const std::string& key);                                 // no error if there is none
  Result<ListPage> list(const std::string& prefix, const std::string& token);  // "" for the first page

  Result<std::string> begin_upload(const std::string& key);
  Result<std::string> put_part(const std::string& key, const std::string& upload, unsigned number,
                               std::span<const std::byte> body, const std::string& sha256);  // returns its ETag
  // false: no such upload. An attempt whose answer was lost has completed it, or it was aborted.
  Result<bool> complete_upload(const std::string& key, const std::string& upload,
                               const std::vector<std::string>& etags);
  Result<Done> abort_upload(const std::string& key, const std::string& upload);  // no error if there is none
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
  const std::string host_;       // for the header Host
  const std::string base_path_;  // "/" or "/BUCKET/"
  net::HttpClient http_;
  Outage outage_;
};

}  // namespace meshgauge::server::store
