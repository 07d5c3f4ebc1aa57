#include "server/handlers/batch_receiver.h"

#include <mutex>
#include <utility>

#include "api/base/digest.h"
#include "server/http/head_values.h"
#include "server/http/name_for_file.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr const char* kManifest = "manifest";
constexpr std::size_t kBytesOfPair = 2048;  // room for two ids, a name and options

std::string shown(const std::string& name) { return "'" + name.substr(0, 64) + "'"; }

// Serializes the parsing of manifests, since a parsed one takes several times its size in memory.
std::mutex& parsing() {
  static std::mutex one;
  return one;
}

}  // namespace

BatchReceiver::BatchReceiver(std::string owner, bool keep, const Settings& settings, const Stores& stores,
                             Access& access, UploadShare share)
    : owner_(std::move(owner)),
      keep_(keep),
      settings_(settings),
      stores_(stores),
      access_(access),
      share_(std::move(share)) {}

BatchReceiver::~BatchReceiver() {
  std::vector<std::string> ids;
  for (const auto& [id, kept] : kept_) ids.push_back(id);
  kept_.clear();
  if (stores_.shared) return;  // another front end may be about to use the same bytes; a sweep removes them later
  for (const std::string& id : ids) {
    const auto removed = remove_if_unreferenced(stores_, {owner_, id});
    static_cast<void>(removed);  // a sweep removes what this could not
  }
}

std::size_t BatchReceiver::max_manifest_bytes() const {
  return api::kMaxOptionsBytes + static_cast<std::size_t>(settings_.max_batch_pairs) * kBytesOfPair;
}

void BatchReceiver::receive(const std::shared_ptr<BatchReceiver>& self, Exchange& exchange, Body::End end) {
  if (const auto refusal = self->expect(exchange)) return end(refusal);
  exchange.body.read(
      [self](std::string_view piece) { return self->parser_ ? self->parser_->feed(piece) : self->data(piece); },
      [self, end = std::move(end)](const Refusal& lost) { end(lost ? lost : self->complete()); });
}

BatchReceiver::Refusal BatchReceiver::expect(Exchange& exchange) {
  std::string_view type = exchange.head.header("content-type");
  if (take_kind(type) == "application/json") {
    current_.name = "body";
    upload_ = std::make_unique<Upload>(share_, settings_.temp_dir);
    return std::nullopt;
  }
  std::string boundary;
  constexpr const char* kWanted =
      "application/json (a manifest of stored meshes), or multipart/form-data whose first part is the manifest "
      "(curl -F manifest=@manifest.json -F x=@part.stl)";
  if (auto refusal = find_boundary(exchange.head.header("content-type"), kWanted, boundary)) return refusal;
  parser_.emplace(boundary, *this);
  return std::nullopt;
}

BatchReceiver::Refusal BatchReceiver::complete() {
  if (parser_) {
    if (auto refusal = parser_->finish()) return refusal;
    return check_complete();
  }
  if (auto refusal = upload_->finish()) return refusal;
  return parse(current_.name, false);
}

BatchReceiver::Refusal BatchReceiver::begin(const FieldHead& field) {
  current_ = field;
  upload_ = std::make_unique<Upload>(share_, settings_.temp_dir);
  if (!parsed_) {
    if (field.name == kManifest) return std::nullopt;
    return field_problem(ProblemKind::malformed_request, kManifest,
                         "the first part must be 'manifest', not " + shown(field.name));
  }
  const std::string name = field.name.substr(0, 64);
  if (field.name == kManifest || files_.contains(field.name)) {
    return field_problem(ProblemKind::malformed_request, name, "the part " + shown(name) + " was sent twice");
  }
  if (awaited_.contains(field.name)) return std::nullopt;
  return field_problem(ProblemKind::malformed_request, name,
                       "no comparison of the manifest names the part " + shown(name));
}

BatchReceiver::Refusal BatchReceiver::data(std::string_view piece) {
  const std::uint64_t most = parsed_ ? settings_.max_part_bytes : max_manifest_bytes();
  if (upload_->size() + piece.size() <= most) return upload_->append(piece);
  return field_problem(ProblemKind::too_large, current_.name,
                       shown(current_.name) + " is larger than the limit of " + std::to_string(most) + " bytes");
}

BatchReceiver::Refusal BatchReceiver::end() {
  if (auto refusal = upload_->finish()) return refusal;
  if (current_.filename.empty()) {
    if (auto refusal = refuse_name_for_file(current_.name, upload_->text())) return refusal;
  }
  return parsed_ ? keep_file() : parse(kManifest, true);
}

BatchReceiver::Refusal BatchReceiver::parse(const std::string& document, bool parts) {
  const std::lock_guard lock(parsing());
  const api::BatchLimits limits{request_limits(settings_), static_cast<std::size_t>(settings_.max_batch_pairs),
                                max_manifest_bytes(), parts};
  auto request = api::parse_batch(upload_->text(), document, limits);
  if (!request) return api::to_problem(request.error());
  request_ = std::move(*request);
  for (const api::BatchPair& pair : request_.pairs) {
    for (const api::BatchMesh* mesh : {&pair.a, &pair.b}) {
      if (!mesh->part.empty()) awaited_.insert(mesh->part);
    }
  }
  parsed_ = true;
  upload_.reset();
  return std::nullopt;
}

// Stores the file before the next one arrives, so that only one is held at a time.
BatchReceiver::Refusal BatchReceiver::keep_file() {
  BatchFile file{api::sha256_hex(upload_->bytes()), upload_->size(), current_.filename, current_.content_type};
  if (keep_) {
    const store::BlobKey key{owner_, file.id};
    Kept& kept = kept_[file.id];
    // NOLINTNEXTLINE(modernize-make-unique): it cannot be moved into place
    if (!kept.reserved) kept.reserved.reset(new store::Reservations::Held(stores_.blobs.reserve(key)));
    kept.put = Clock::now();
    if (auto refusal = put(key)) return refusal;
  }
  files_.emplace(current_.name, std::move(file));
  upload_.reset();
  return std::nullopt;
}

BatchReceiver::Refusal BatchReceiver::put(const store::BlobKey& key) {
  const auto there = stores_.blobs.exists(key);
  if (!there) return api::to_problem(there.error());
  const auto hold = hold_storage(access_, stores_, owner_, *there ? 0 : upload_->size(), settings_.max_stored_bytes);
  if (const auto* denial = std::get_if<Denial>(&hold)) return denial->problem;
  const auto stored = stores_.blobs.put(key, upload_->bytes());
  if (!stored) return api::to_problem(stored.error());
  return std::nullopt;
}

BatchReceiver::Refusal BatchReceiver::renew(std::chrono::seconds older_than) {
  for (auto& [id, kept] : kept_) {
    const auto now = Clock::now();
    if (now - kept.put < older_than) continue;
    const auto renewed = stores_.blobs.renew({owner_, id});
    if (!renewed) return api::to_problem(renewed.error());
    if (!*renewed)
      return Problem{ProblemKind::storage_unavailable,
                     "a file of the batch was removed before the batch was stored; send the batch again"};
    kept.put = now;
  }
  return std::nullopt;
}

BatchReceiver::Refusal BatchReceiver::check_complete() const {
  if (!parsed_) return field_problem(ProblemKind::malformed_request, kManifest, "the part 'manifest' is missing");
  for (const std::string& name : awaited_) {
    if (files_.contains(name)) continue;
    return field_problem(ProblemKind::malformed_request, name, "the part " + shown(name) + " is missing");
  }
  return std::nullopt;
}

}  // namespace meshgauge::server
