#include "tests/fuzz/targets/mesh_file.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "api/formats/format.h"
#include "api/formats/read_part.h"
#include "api/formats/weld.h"
#include "tests/api/formats/zip_files.h"
#include "tests/fuzz/targets/checks.h"

namespace meshgauge::fuzz {
namespace {

using api::Format;
using api::ReadMesh;

constexpr std::string_view kGzip = "\x1F\x8B";
constexpr const char* kOtherNames[] = {"",       "m.obj", "m.stl", "m.ply", "m.off",
                                       "m.gltf", "m.glb", "m.xyz", "m.png", "m.obj.gz"};

api::ReadLimits limits() {
  api::ReadLimits out;
  out.max_vertices = 100'000;
  out.max_triangles = 100'000;
  out.max_expanded_bytes = std::size_t{4} << 20;
  return out;
}

// From a copy of exactly the bytes: a sanitizer sees every read beyond, and no two readings see the same addresses.
Result<ReadMesh> read(std::string_view file, std::string_view filename) {
  const std::vector<char> exact(file.begin(), file.end());
  return read_mesh(std::as_bytes(std::span<const char>(exact)), {"a", filename, ""}, limits());
}

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

bool same(const Result<ReadMesh>& a, const Result<ReadMesh>& b) {
  if (a.ok() != b.ok()) return false;
  if (!a) {
    return a.error().code == b.error().code && a.error().message == b.error().message &&
           a.error().where == b.error().where;
  }
  return a->format == b->format && a->notes.cloud == b->notes.cloud && a->notes.polygons == b->notes.polygons &&
         a->notes.skipped_primitives == b->notes.skipped_primitives &&
         same_bytes(a->mesh.positions, b->mesh.positions) && same_bytes(a->mesh.triangles, b->mesh.triangles);
}

std::string told(const Result<ReadMesh>& result) {
  if (!result) return result.error().message;
  return std::string(to_string(result->format)) + ", " + std::to_string(result->mesh.positions.size()) + " vertices, " +
         std::to_string(result->mesh.triangles.size()) + " triangles";
}

void require_same(const Result<ReadMesh>& a, const Result<ReadMesh>& b, const char* what) {
  if (!same(a, b)) require(false, what, told(a) + "\n" + told(b));
}

// Each vertex and triangle of these takes bytes of its own.
bool has_room_for_each(Format format) {
  return format == Format::obj || format == Format::stl || format == Format::ply || format == Format::off ||
         format == Format::xyz;
}

void require_sound(const ReadMesh& read) {
  const Mesh& mesh = read.mesh;
  require(!read.notes.cloud || is_cloud(mesh), "a cloud has points alone");
  require(!mesh.triangles.empty(), "an accepted mesh has triangles");
  require(mesh.positions.size() <= limits().max_vertices && mesh.triangles.size() <= limits().max_triangles,
          "counts are within the limits");
  for (const Triangle& triangle : mesh.triangles) {
    for (const std::uint32_t index : triangle) require(index < mesh.positions.size(), "indices are in range");
  }
  for (const Vec3& p : mesh.positions) require(p.allFinite(), "coordinates are finite");
  const auto valid = validate(mesh, MeshLimits{limits().max_vertices, limits().max_triangles}, "a");
  require(valid.ok(), "validate() agrees", valid ? "" : valid.error().message);
  require(is_valid(read.groups, mesh.triangles.size()), "groups are of the mesh's triangles");
}

void require_refusal(const Error& error) {
  require(error.part == "a" && error.message.find("'a'") != std::string::npos, "a refusal names its part",
          error.message);
  for (const char c : error.message) require(c >= ' ' && c <= '~', "a message is printable", error.message);
  require(error.code != ErrorCode::internal, "no file is an internal failure", error.message);
}

std::optional<Format> detected(std::string_view file, std::string_view filename) {
  return api::detect_format(std::as_bytes(std::span<const char>(file)), {"a", filename, ""});
}

// Merged corners have the same bits, whether a reader merges them itself or leaves it to weld().
void require_part(Result<ReadMesh> read, std::string_view file, std::string_view filename) {
  const auto part = api::read_part(std::as_bytes(std::span<const char>(file)), {"a", filename, ""}, limits());
  if (read && read->mesh.positions.size() == 3 * read->mesh.triangles.size()) {
    require(part && part->notes.welded_vertices == api::weld(read->mesh), "vertices are merged as weld() does",
            told(part));
  }
  require_same(read, part, "vertices are merged, and nothing else is different");
}

}  // namespace

void check_mesh_file(std::string_view file, std::string_view filename) {
  const auto result = read(file, filename);
  require_part(result, file, filename);
  require_same(result, read(file, filename), "the same bytes give the same answer");
  if (!result) require_refusal(result.error());
  if (result) require_sound(*result);
  if (file.starts_with(kGzip)) return;
  if (result) {
    require(result->format == detected(file, filename), "the format is the one detected");
    const std::size_t most = std::max(result->mesh.positions.size(), result->mesh.triangles.size());
    require(!has_room_for_each(result->format) || most <= file.size(), "counts are within the bytes");
  }
  if (!detected(file, "")) return;
  Dice dice = dice_of(file);
  require_same(result, read(file, dice.pick(kOtherNames)), "a name changes nothing where the content tells the format");
}

void check_file_of(std::string_view format, std::string_view file) {
  const std::string filename = "m." + std::string(format);
  const auto found = detected(file, filename);
  if (file.starts_with(kGzip) || (found && to_string(*found) != format)) return;
  check_mesh_file(file, filename);
}

void check_compressed(std::string_view file) {
  if (file.starts_with(kGzip)) return;
  const auto plain = read(file, "");
  std::string gzip = api::test::gzipped(file);
  const auto result = read(gzip, "");
  require_same(plain, result, "gzip changes nothing");
  require(!result || result->notes.gzip, "gzip is noted");
  Dice dice = dice_of(file);
  char& changed = gzip[2 + dice.below(static_cast<std::uint32_t>(gzip.size() - 2))];  // it stays gzip by its first two
  changed = static_cast<char>(static_cast<unsigned char>(changed) ^ (1U << dice.below(8)));
  const auto damaged = read(gzip, "");
  if (damaged) require_same(plain, damaged, "damaged gzip is refused, or gives the same");
}

}  // namespace meshgauge::fuzz
