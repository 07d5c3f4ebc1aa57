#include "api/compare/mesh_file.h"

#include <algorithm>
#include <limits>
#include <map>
#include <new>
#include <utility>
#include <vector>

#include "api/base/text.h"
#include "api/formats/gltf/gltf_bundle.h"

namespace meshgauge::api {
namespace {

using Files = std::map<std::string, WholeFile>;  // by their paths in the archive, in its order

Error named_by(const std::string& path, Error error) {
  error.message = "'" + path + "' is a glTF of several files: " + error.message;
  return error;
}

// The Error about the file at `place`, which is called `path`.
Error named(Error error, const std::string& place, const std::string& path) {
  replace_all(error.message, "'" + place + "'", "'" + path + "'");
  return error;
}

Error too_large(const std::string& path, const std::string& what) {
  return named_by(path, {ErrorCode::too_large, "it and the files that it names are " + what, "", ""});
}

Result<Files> files_of(const std::string& path, WholeFile scene, const std::vector<std::string>& names,
                       const BaseFolder& folder, const std::string& before, std::uint64_t most) {
  if (names.size() > kMostBundleFiles) {
    return named_by(
        path, {ErrorCode::too_large,
               "it names " + std::to_string(names.size()) + " files (limit " + std::to_string(kMostBundleFiles) + ")",
               "", ""});
  }
  const std::uint64_t all = std::min(kMostBundleBytes, most);
  std::uint64_t left = all - std::min(all, BundleWriter::bytes_for_end());
  Files files;
  const auto add = [&](const std::string& name, WholeFile file) {
    const std::uint64_t bytes = BundleWriter::bytes_for(name, file.bytes().size());
    if (bytes > left) return false;
    left -= bytes;
    return files.emplace(name, std::move(file)).second;
  };
  for (const std::string& name : names) {
    if (is_scene_path(name))
      return named_by(path, {ErrorCode::unreadable_mesh,
                             "a buffer names '" + name + "', a .gltf; name a file of binary data", "", ""});
  }
  bool fits = add(std::string(kBundleScene), std::move(scene));
  for (const std::string& name : names) {
    if (!fits) break;
    auto file = WholeFile::open_below(folder, before + name, left);
    if (!file) return named_by(path, std::move(file).error());
    fits = add(name, std::move(*file));
  }
  const std::string limit = most < kMostBundleBytes ? std::to_string(most) + " bytes" : "4 GiB";
  if (!fits) return too_large(path, "larger than " + limit);
  return files;
}

std::string bundle_of(const Files& files) {
  std::uint64_t bytes = BundleWriter::bytes_for_end();
  for (const auto& [name, file] : files) bytes += BundleWriter::bytes_for(name, file.bytes().size());
  std::string bundle;
  bundle.reserve(bytes);
  BundleWriter writer([&](std::string_view piece) { return bundle += piece, true; });
  for (const auto& [name, file] : files) writer.add(name, file.bytes());
  writer.finish();
  return bundle;
}

Error larger_than_memory(const std::string& path) {
  return {ErrorCode::too_large, "'" + path + "' with the files that it names is larger than the memory", "", ""};
}

}  // namespace

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

Result<MeshFile> MeshFile::of_pipe(const std::string& name, std::span<const std::byte> bytes) {
  const auto files = is_gltf_json(bytes) ? files_named_by(bytes) : std::vector<std::string>{};
  if (files.empty()) return MeshFile(bytes);
  return named_by(name, {ErrorCode::unreadable_mesh,
                         "it came through a pipe, which has no folder for '" + files.front() +
                             "'; name the .gltf itself, or send a .glb or a .zip with all files",
                         "", ""});
}

Result<MeshFile> MeshFile::of_file(const std::string& path, WholeFile whole, const BaseFolder& folder,
                                   const std::string& before, std::uint64_t most) {
  const auto bytes = whole.bytes();
  if (!is_gltf_json(bytes)) return MeshFile(std::move(whole));
  const std::vector<std::string> names = files_named_by(bytes);
  if (names.empty()) return MeshFile(std::move(whole));
  const auto files = files_of(path, std::move(whole), names, folder, before, most);
  if (!files) return files.error();
  return MeshFile(bundle_of(*files));
}

Result<MeshFile> MeshFile::open(const std::string& path, const Pipes* pipes, const Copies* copies) try {
  if (const auto sent = pipes ? pipes->find(path) : Pipes::const_iterator{}; pipes && sent != pipes->end())
    return of_pipe(path, sent->second.bytes());
  const auto copy = copies ? copies->find(path) : Copies::const_iterator{};
  const std::string& place = copies && copy != copies->end() ? copy->second : path;
  auto whole = WholeFile::open(place);
  if (!whole) return named(std::move(whole).error(), place, path);
  return of_file(path, std::move(*whole), {folder_of(place).string()}, "", std::numeric_limits<std::uint64_t>::max());
} catch (const std::bad_alloc&) {
  return larger_than_memory(path);
}

Result<ByteBudget::Lease> MeshFile::lease(const Confines& confines, std::uint64_t bytes, const std::string& path) {
  if (!confines.files) return ByteBudget::Lease();
  auto taken = ByteBudget::take(confines.files, bytes);
  if (taken) return taken;
  return Error{ErrorCode::too_large,
               "'" + path +
                   "' does not fit into memory beside the other files that are read now: wait for an answer, then call "
                   "again, or write a smaller file",
               "", ""};
}

Result<MeshFile> MeshFile::open_within(const Confines& confines, const std::string& path) try {
  const auto place = confines.roots.find(path);
  if (!place) return place.error();
  const auto size = WholeFile::size_below(place->folder, place->name);
  if (!size) return size.error();
  const auto of_file_itself = lease(confines, std::min(*size, confines.max_file_bytes), path);
  if (!of_file_itself) return of_file_itself.error();
  auto whole = WholeFile::open_below(place->folder, place->name, confines.max_file_bytes);
  if (!whole) return std::move(whole).error();
  const std::string before = place->name.substr(0, place->name.rfind('/') + 1);  // empty without a folder
  auto file = of_file(path, std::move(*whole), place->folder, before, confines.max_file_bytes);
  if (!file) return file;
  const std::uint64_t bytes = file->bytes().size();
  const auto of_others = lease(confines, bytes - std::min(bytes, *size), path);
  if (!of_others) return of_others.error();
  file->leases_ = {*of_file_itself, *of_others};
  return file;
} catch (const std::bad_alloc&) {
  return larger_than_memory(path);
}

}  // namespace meshgauge::api
