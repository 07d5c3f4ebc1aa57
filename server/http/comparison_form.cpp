#include "server/http/comparison_form.h"

#include <algorithm>

#include "api/formats/file/file_path.h"
#include "api/formats/file/source.h"
#include "api/formats/gltf/gltf_bundle.h"
#include "api/options/request.h"
#include "server/http/name_for_file.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr std::uint64_t kMostDiscarded = std::uint64_t{16} << 20;
constexpr std::size_t kMostNamesShown = 8;
constexpr std::size_t kMostNameShown = 64;

Problem twice(const std::string& part) {
  return field_problem(ProblemKind::malformed_request, part, "the part '" + part + "' was sent twice");
}

Problem too_large(const std::string& part, const std::string& is, std::uint64_t limit) {
  return field_problem(
      ProblemKind::too_large, part,
      "the part '" + part + "' " + is + " larger than the limit of " + std::to_string(limit) + " bytes");
}

}  // namespace

FormReceiver::Refusal FormReceiver::begin(const FieldHead& field) {
  current_ = field.name;
  mesh_ = nullptr;
  upload_ = nullptr;
  if (++count_ <= kMostNamesShown) names_.push_back(api::printable(field.name, kMostNameShown));
  if (!unknown_.empty()) return std::nullopt;
  if (field.name == "options") {
    if (options_seen_) return twice(field.name);
    options_seen_ = true;
    form_.options.clear();
    return std::nullopt;
  }
  if (field.name == "a") return begin_mesh(field, form_.a);
  if (field.name == "b") return begin_mesh(field, form_.b);
  if (field.name == "a.files") return begin_file(field, form_.a);
  if (field.name == "b.files") return begin_file(field, form_.b);
  unknown_ = field.name;
  return std::nullopt;
}

FormReceiver::Refusal FormReceiver::begin_mesh(const FieldHead& field, MeshField& mesh) {
  if (mesh.upload) return twice(field.name);
  mesh.head = field;
  mesh.upload = std::make_unique<Upload>(share_, settings_.temp_dir);
  mesh_ = &mesh;
  upload_ = mesh.upload.get();
  return std::nullopt;
}

// The name comes from the client. It is never opened as a path; names that no .gltf could refer to are refused anyway.
FormReceiver::Refusal FormReceiver::begin_file(const FieldHead& field, MeshField& mesh) {
  const auto refuse = [&](const std::string& what) {
    return field_problem(ProblemKind::malformed_request, field.name, what);
  };
  if (mesh.files.size() == api::kMostBundleFiles) {
    return refuse("too many parts '" + field.name + "' (limit " + std::to_string(api::kMostBundleFiles) + ")");
  }
  const std::string shown = "the file name " + api::in_quotes(field.filename) + " of a part '" + field.name + "' ";
  api::FilePath file = api::file_path_of_name(field.filename);
  if (!file.defect.empty()) return refuse(shown + file.defect);
  if (api::is_scene_path(file.path))
    return refuse(shown + "is that of a .gltf; send the .gltf itself as the part without '.files'");
  const auto has_key = [key = api::file_key(file.path)](const SentFile& sent) {
    return api::file_key(sent.path) == key;
  };
  if (const auto sent = std::ranges::find_if(mesh.files, has_key); sent != mesh.files.end()) {
    return refuse(shown + (sent->path == file.path ? "was sent twice"
                                                   : "differs from " + api::in_quotes(sent->path) +
                                                         " by letter case alone: rename one of the files"));
  }
  mesh.files.push_back({std::move(file.path), std::make_unique<Upload>(share_, settings_.temp_dir)});
  mesh_ = &mesh;
  upload_ = mesh.files.back().upload.get();
  return std::nullopt;
}

FormReceiver::Refusal FormReceiver::data(std::string_view piece) {
  if (!unknown_.empty()) {
    discarded_ += piece.size();
    return discarded_ > kMostDiscarded ? Refusal(unknown()) : std::nullopt;
  }
  if (!upload_) return add_option_bytes(piece);
  if (bytes_of(*mesh_) + piece.size() > settings_.max_part_bytes) {
    return too_large(current_, mesh_->files.empty() ? "is" : "and the files beside it are together",
                     settings_.max_part_bytes);
  }
  return upload_->append(piece);
}

FormReceiver::Refusal FormReceiver::add_option_bytes(std::string_view piece) {
  if (form_.options.size() + piece.size() > api::kMaxOptionsBytes)
    return too_large(current_, "is", api::kMaxOptionsBytes);
  form_.options.append(piece);
  return std::nullopt;
}

FormReceiver::Refusal FormReceiver::end() {
  if (!unknown_.empty()) return std::nullopt;
  if (!upload_) return refuse_name_for_file(current_, form_.options);
  if (auto refusal = upload_->finish(mesh_->files.empty())) return refusal;
  const bool has_name = upload_ != mesh_->upload.get() || !mesh_->head.filename.empty();
  return has_name ? std::nullopt : refuse_name_for_file(current_, upload_->text());
}

FormReceiver::Refusal FormReceiver::complete() {
  if (!unknown_.empty()) return unknown();
  if (!form_.a.upload) return missing("a");
  if (!form_.b.upload) return missing("b");
  for (MeshField* mesh : {&form_.a, &form_.b}) {
    if (auto refusal = combine_files(*mesh, settings_.max_part_bytes, share_, settings_.temp_dir)) return refusal;
  }
  return std::nullopt;
}

Problem FormReceiver::unknown() const {
  const std::string name = unknown_.substr(0, kMostNameShown);
  return field_problem(ProblemKind::malformed_request, name,
                       "unknown part '" + api::printable(unknown_, kMostNameShown) + "'; " + fields_sent() +
                           "; known: a and b, the meshes, options, and a.files and b.files, what a .gltf names");
}

Problem FormReceiver::missing(const std::string& part) const {
  return field_problem(ProblemKind::malformed_request, part, "the part '" + part + "' is missing; " + fields_sent());
}

std::string FormReceiver::fields_sent() const {
  if (names_.empty()) return "the form holds no part";
  std::string text = "the form holds ";
  for (const std::string& name : names_) text += (&name == names_.data() ? "'" : ", '") + name + "'";
  return count_ > names_.size() ? text + " and " + std::to_string(count_ - names_.size()) + " more" : text;
}

}  // namespace meshgauge::server
