// The request of a batch as it streams in: its manifest, and mesh files that this names.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "api/batch_request.h"
#include "server/access/access.h"
#include "server/http/exchange.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"
#include "server/jobs/kept_blobs.h"
#include "server/settings.h"

namespace meshgauge::server {

// A mesh file that came with a batch.
struct BatchFile {
  std::string id;  // its SHA-256
  std::uint64_t bytes = 0;
  std::string file_name;
  std::string media_type;
};

class BatchReceiver final : public MultipartSink {
 public:
  using Refusal = std::optional<api::Problem>;

  // Borrows all but the owner. `keep`: files go into the blob store as they come, reserved as long as this object
  // lives; else they are only looked at.
  BatchReceiver(std::string owner, bool keep, const Settings& settings, const Stores& stores, Access& access,
                ByteBudget& budget);
  // Files that nothing refers to by now are removed.
  ~BatchReceiver() override;
  BatchReceiver(const BatchReceiver&) = delete;
  BatchReceiver& operator=(const BatchReceiver&) = delete;

  // All of the body, JSON or a form. Once.
  Refusal receive(Exchange& exchange);
  // Of the files that were kept so long ago: makes them young again, so that a sweep which began before the batch is
  // stored leaves them to it. Refused when one is gone.
  Refusal renew(std::chrono::seconds older_than);

  const api::BatchRequest& request() const { return request_; }
  const std::map<std::string, BatchFile>& files() const { return files_; }  // by the part's name

 private:
  struct Kept {
    std::unique_ptr<const store::Reservations::Held> reserved;
    Clock::time_point put;
  };

  Refusal receive_form(Exchange& exchange);
  Refusal receive_manifest(Exchange& exchange);
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
  ByteBudget& budget_;
  api::BatchRequest request_;
  bool parsed_ = false;
  std::set<std::string> awaited_;  // parts that the manifest names
  std::map<std::string, BatchFile> files_;
  std::map<std::string, Kept> kept_;  // by id
  FieldHead current_;
  std::unique_ptr<Upload> upload_;  // of the part that is arriving
};

}  // namespace meshgauge::server
