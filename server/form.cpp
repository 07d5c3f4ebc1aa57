#include "server/form.h"

#include "api/request.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

Problem about_part(ProblemKind kind, const std::string& part, const std::string& what) {
  return Problem{kind, what, {{part, "", what}}};
}

Problem twice(const std::string& part) {
  return about_part(ProblemKind::malformed_request, part, "the part '" + part + "' was sent twice");
}

Problem missing(const std::string& part) {
  return about_part(ProblemKind::malformed_request, part, "the part '" + part + "' is missing");
}

Problem too_large(const std::string& part, std::uint64_t limit) {
  return about_part(ProblemKind::too_large, part,
                    "the part '" + part + "' is larger than the limit of " + std::to_string(limit) + " bytes");
}

}  // namespace

FormReceiver::Refusal FormReceiver::begin(const PartHead& part) {
  current_ = part.name;
  upload_ = nullptr;
  if (part.name == "options") {
    if (options_seen_) return twice(part.name);
    options_seen_ = true;
    form_.options.clear();
    return std::nullopt;
  }
  if (part.name != "a" && part.name != "b") {
    return about_part(ProblemKind::malformed_request, part.name.substr(0, 64),
                      "unknown part '" + part.name.substr(0, 64) + "'; known: a, b, options");
  }
  MeshPart& mesh = part.name == "a" ? form_.a : form_.b;
  if (mesh.upload) return twice(part.name);
  mesh = {part, std::make_unique<Upload>(budget_, settings_.temp_dir)};
  upload_ = mesh.upload.get();
  return std::nullopt;
}

FormReceiver::Refusal FormReceiver::data(std::string_view piece) {
  if (!upload_) return add_option_bytes(piece);
  if (upload_->size() + piece.size() > settings_.max_part_bytes) return too_large(current_, settings_.max_part_bytes);
  return upload_->append(piece);
}

FormReceiver::Refusal FormReceiver::add_option_bytes(std::string_view piece) {
  if (form_.options.size() + piece.size() > api::kMaxOptionsBytes) return too_large(current_, api::kMaxOptionsBytes);
  form_.options.append(piece);
  return std::nullopt;
}

FormReceiver::Refusal FormReceiver::end() { return upload_ ? upload_->finish() : std::nullopt; }

FormReceiver::Refusal FormReceiver::check_complete() const {
  if (!form_.a.upload) return missing("a");
  if (!form_.b.upload) return missing("b");
  return std::nullopt;
}

}  // namespace meshgauge::server
