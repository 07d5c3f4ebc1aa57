#include "check/remote/sender.h"

#include <algorithm>
#include <chrono>
#include <span>
#include <utility>

#include "api/base/digest.h"
#include "api/compare/mesh_file.h"
#include "api/formats/detect.h"
#include "api/formats/file/gzip.h"
#include "check/remote/address.h"
#include "check/remote/answer.h"

namespace meshgauge::check::service {
namespace {

using Bytes = std::span<const std::byte>;

constexpr std::size_t kPiece = std::size_t{4} << 20;  // bytes hashed between two checks of `control`
constexpr std::size_t kSlowest = 10'000;              // bytes per second; slower uploads fail

std::chrono::milliseconds limit_of(std::size_t bytes) {
  return std::chrono::milliseconds(120'000) + std::chrono::seconds(bytes / kSlowest);
}

const std::filesystem::path& file_of(const Gate& gate, Sender::Part part) {
  return part == Sender::Part::candidate ? gate.candidate : gate.baseline;
}

Error named(Error error, Sender::Part part) {
  error.part = part == Sender::Part::candidate ? "a" : "b";
  return error;
}

}  // namespace

Result<std::string> Sender::stored(const Gate& gate, Part part, Control& control) {
  const auto& file = file_of(gate, part);
  auto id = ids_.get(file.string(), control, [&] { return hash(gate, file, control); });
  if (!id) return named(std::move(id).error(), part);
  const auto done = delivered_.get(*id, control, [&] { return deliver(gate, file, *id, control); });
  if (!done) return named(done.error(), part);
  return id;
}

// Refuses a file that cannot be a mesh without sending it, with the message that the reader would give.
Result<std::string> Sender::hash(const Gate& gate, const std::filesystem::path& file, Control& control) {
  const auto whole = api::MeshFile::open(file.string(), gate.pipes.get(), gate.copies.get());
  if (!whole) return whole.error();
  const std::string name = file.string();
  // Gzip-compressed files are checked by the service.
  const bool packed = api::is_gzip(whole->bytes());
  if (auto foreign = api::refuse_foreign(whole->bytes(), {name, name, ""}); foreign && !packed) return *foreign;
  api::Sha256 sha256;
  for (Bytes rest = whole->bytes(); !rest.empty();) {
    if (control.check() == Interruption::cancelled) return cancelled();
    const Bytes piece = rest.first(std::min(kPiece, rest.size()));
    sha256.update(piece);
    rest = rest.subspan(piece.size());
  }
  return sha256.hex();
}

Result<Done> Sender::deliver(const Gate& gate, const std::filesystem::path& file, const std::string& id,
                             Control& control) {
  const auto known = client_.ask({"HEAD", "/v1/meshes/" + id, {}}, control, gate.request.timeout);
  if (!known) return known.error();
  if (known->status == 200) return Done{};
  // A refused HEAD has no body that says why; PUT has.
  return put(gate, file, id, control);
}

Result<Done> Sender::put(const Gate& gate, const std::filesystem::path& file, const std::string& id, Control& control) {
  control.report({0, Progress{}.upper, "send"});
  const auto whole = api::MeshFile::open(file.string(), gate.pipes.get(), gate.copies.get());
  if (!whole) return whole.error();
  const HttpRequest request{"PUT",
                            "/v1/meshes/" + id,
                            {{"Content-Type", std::string(whole->media_type())},
                             {"Content-Disposition", disposition(file.string() + std::string(whole->more_suffix()))}},
                            whole->bytes(),
                            limit_of(whole->bytes().size())};
  const auto reply = client_.ask(request, control, gate.request.timeout);
  if (!reply) return reply.error();
  if (reply->status == 200 || reply->status == 201) return Done{};
  const auto problem = problem_from(std::string_view(reply->body));
  if (problem && problem->slug == "digest-mismatch") {
    return Error{ErrorCode::internal, "'" + file.string() + "' was changed while it was sent", "", ""};
  }
  Error error = error_of(*reply, gate, client_.base(), client_.has_key());
  if (problem) error.message = "'" + file.string() + "' is not taken: " + error.message;
  return error;
}

}  // namespace meshgauge::check::service
