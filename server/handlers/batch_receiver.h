// Receives the request of a batch: its manifest, and the mesh files that the manifest names.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "api/options/batch_request.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"
#include "server/measure/kept_blobs.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// A mesh of a batch: a file that was uploaded with it, or a stored mesh.
struct BatchFile {
  std::string id;  // its SHA-256
  std::uint64_t bytes = 0;
  std::string file_name;
  std::string media_type;
};

class BatchReceiver final : public MultipartSink {
 public:
  using Refusal = std::optional<api::Problem>;

  // Borrows all but the owner, also the budget of the share. `keep`: store each file as a blob when it has arrived,
  // reserved for the lifetime of this object. Without it, files are only hashed.
  BatchReceiver(std::string owner, bool keep, const Settings& settings, const Stores& stores, Access& access,
                UploadShare share);
  // Removes stored files that no row refers to; in the distributed form a sweep does.
  ~BatchReceiver() override;
  BatchReceiver(const BatchReceiver&) = delete;
  BatchReceiver& operator=(const BatchReceiver&) = delete;

  // Begins to read the body, JSON or a form. `end` is called with nullopt when all of it has arrived, else with the
  // problem. `self`: keeps this object until then. Call once.
  static void receive(const std::shared_ptr<BatchReceiver>& self, Exchange& exchange, Body::End end);
  // Renews the age of files stored more than `older_than` ago, so that a sweep does not remove them before the batch is
  // stored. Returns a problem if one is gone.
  Refusal renew(std::chrono::seconds older_than);

  const api::BatchRequest& request() const { return request_; }
  const std::map<std::string, BatchFile>& files() const { return files_; }  // by field name

 private:
  struct Kept {
    std::unique_ptr<const store::Reservations::Held> reserved;
    Clock::time_point put;
  };

  Refusal expect(Exchange& exchange);
  Refusal complete();
  Refusal begin(const FieldHead& field) override;
  Refusal data(std::string_view piece) override;
  Refusal end() override;
  Refusal parse(const std::string& document, bool parts);
  Refusal keep_file();
  Refusal put(const store::BlobKey& key);
  Refusal check_complete() const;
  std::size_t max_manifest_bytes() const;

  const std::string owner_;
  const bool keep_;
  const Settings& settings_;
  const Stores& stores_;
  Access& access_;
  const UploadShare share_;
  api::BatchRequest request_;
  bool parsed_ = false;
  std::set<std::string> awaited_;  // fields that the manifest names
  std::map<std::string, BatchFile> files_;
  std::map<std::string, Kept> kept_;       // by id
  std::optional<MultipartParser> parser_;  // null: the body is the manifest
  FieldHead current_;
  std::unique_ptr<Upload> upload_;  // of the field that is arriving
};

}  // namespace meshgauge::server
