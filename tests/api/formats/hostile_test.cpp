// Damaged files of every format: cut at every length, with each byte changed, with bytes changed at random. Each is
// read or refused with a message; what is read is consistent, and is the file's mesh where its format can tell. Run
// under a sanitizer, this is a small fuzzer; docs/fuzzing.md has the large one.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <set>

#include "tests/api/formats/files.h"
#include "tests/api/formats/small_files.h"
#include "tests/api/formats/zip_files.h"
#include "tests/today.h"

namespace meshgauge::api::test {
namespace {

Result<ReadMesh> read_damaged(const std::string& content, const std::string& name) {
  ReadLimits limits;
  limits.max_vertices = 10'000;
  limits.max_triangles = 10'000;
  limits.max_expanded_bytes = 1'000'000;
  return read(content, name, limits);
}

// Checks that the file is read or refused with a message, and that the mesh is consistent.
void check_sound(const Result<ReadMesh>& result) {
  if (!result) {
    REQUIRE(result.error().part == "a");
    REQUIRE(contains(result.error().message, "'a'"));
    REQUIRE(result.error().code != ErrorCode::internal);
    return;
  }
  const auto valid = validate(result->mesh, MeshLimits{10'000, 10'000}, "a");
  REQUIRE(valid.ok());
  REQUIRE(std::ranges::all_of(result->mesh.positions, [](const Vec3& p) { return p.allFinite(); }));
}

void check_sound(const std::string& content, const std::string& name) { check_sound(read_damaged(content, name)); }

template <class T>
bool begins_with(const std::vector<T>& whole, const std::vector<T>& start, std::size_t count) {
  return count <= start.size() && start.size() <= whole.size() &&
         std::equal(start.begin(), start.begin() + static_cast<std::ptrdiff_t>(count), whole.begin());
}

std::size_t lines_of_vertices(std::string_view obj) {
  std::size_t count = obj.starts_with("v ") ? 1 : 0;
  for (std::size_t at = 0; (at = obj.find("\nv ", at)) != std::string_view::npos; ++at) ++count;
  return count;
}

// For a file whose format cannot tell: only whole parts are read.
void check_whole_parts(const SmallFile& file, const Mesh& whole, std::string_view left, const Mesh& mesh) {
  CHECK(mesh.triangles.size() == file.whole_parts(left));
  CHECK(begins_with(whole.triangles, mesh.triangles, mesh.triangles.size()));
  if (format_of(file) == "obj") {
    CHECK(mesh.positions.size() == lines_of_vertices(left));
    // A cut within a number leaves another number, in the last line if that is a vertex.
    const std::size_t last_line = left.rfind('\n') + 1;
    CHECK(begins_with(whole.positions, mesh.positions, lines_of_vertices(left.substr(0, last_line))));
  } else {
    CHECK(begins_with(whole.positions, mesh.positions, 3 * mesh.triangles.size()));
  }
}

// For points, of which no format but PLY tells how many there are: a cut within the last number leaves another number.
void check_points(const SmallFile& file, const Mesh& whole, const Mesh& mesh) {
  CHECK((format_of(file) == "xyz" || format_of(file) == "obj"));
  CHECK(begins_with(whole.positions, mesh.positions, mesh.positions.size() - 1));
}

void check_cut(const SmallFile& file, const Mesh& whole, std::size_t kept) {
  CAPTURE(kept);
  const std::string left = file.content.substr(0, kept);
  const auto result = read_damaged(left, file.name);
  check_sound(result);
  const bool between_lines = left.ends_with('\n') && format_of(file) == "obj" && file.whole_parts != nullptr;
  const bool cloud = result && result->notes.cloud;
  if (between_lines) CHECK((result.ok() && !cloud) == (file.whole_parts(left) > 0));
  if (!result) return;
  if (cloud) return check_points(file, whole, result->mesh);
  if (file.whole_parts != nullptr) return check_whole_parts(file, whole, left, result->mesh);
  CHECK(kept >= file.content.size() - file.spare);
  CHECK(result->mesh.positions == whole.positions);
  CHECK(result->mesh.triangles == whole.triangles);
}

}  // namespace

TEST_CASE("hostile: the small files are valid and have the contents of their table") {
  for (const SmallFile& file : small_files()) {
    CAPTURE(file.name);
    const auto result = read(file.content, file.name);
    INFO((result ? "" : result.error().message));
    REQUIRE(result.ok());
    CHECK(to_string(result->format) == format_of(file));
    CHECK(result->mesh.positions.size() == file.vertices);
    CHECK(result->mesh.triangles.size() == file.triangles);
    if (file.whole_parts != nullptr) CHECK(file.whole_parts(file.content) == file.triangles);
  }
}

TEST_CASE("hostile: every format has a small file, in each of its encodings") {
  std::set<std::string> names;
  for (const SmallFile& file : small_files()) names.insert(file.name.ends_with(".gz") ? "gz" : format_of(file));
  CHECK(names == std::set<std::string>{"3mf", "obj", "stl", "ply", "off", "gltf", "glb", "xyz", "gz"});
}

TEST_CASE("hostile: a file cut at any length is refused, or read as far as it is whole") {
  for (const SmallFile& file : small_files()) {
    CAPTURE(file.name);
    const auto whole = read(file.content, file.name);
    REQUIRE(whole.ok());
    for (std::size_t kept = 0; kept < file.content.size(); ++kept) check_cut(file, whole->mesh, kept);
  }
}

TEST_CASE("hostile: the rest after any cut is read or refused") {
  for (const SmallFile& file : small_files()) {
    CAPTURE(file.name);
    for (std::size_t lost = 1; lost < file.content.size(); ++lost) check_sound(file.content.substr(lost), file.name);
  }
}

TEST_CASE("hostile: a changed byte does not change counts without a word, where the format can tell") {
  std::uint64_t number = 0;
  for (const SmallFile& file : small_files()) {
    CAPTURE(file.name);
    const auto remarks = read(file.content, file.name)->notes.remarks;
    const auto near = [&](std::size_t count, std::size_t whole) {
      return count <= whole + file.unnoticed && whole <= count + file.unnoticed;
    };
    for (std::size_t at = 0; at < file.content.size(); ++at) {
      for (unsigned pattern : {0x01U, 0x02U, 0x04U, 0x08U, 0x10U, 0x20U, 0x40U, 0x80U, 0xFFU}) {
        if (!is_of_today(number++, 4)) continue;
        std::string content = file.content;
        content[at] = static_cast<char>(static_cast<unsigned char>(content[at]) ^ pattern);
        CAPTURE(at);
        CAPTURE(pattern);
        const auto result = read_damaged(content, file.name);
        check_sound(result);
        if (!result || (result->notes.cloud && format_of(file) != "xyz")) continue;  // its faces became another element
        if (result->notes.remarks != remarks) continue;                              // the loss is said
        CHECK(near(result->mesh.positions.size(), file.vertices));
        CHECK(near(result->mesh.triangles.size(), file.triangles));
      }
    }
  }
}

TEST_CASE("hostile: the model of a 3MF, cut or changed inside its archive, is read or refused") {
  for (const std::string& whole : {small_model(), small_foreign_model()}) {
    for (std::size_t at = 0; at < whole.size(); ++at) {
      CAPTURE(at);
      const auto cut = read_damaged(package(whole.substr(0, at)), "m.3mf");
      check_sound(cut);
      CHECK(cut.ok() == (at >= whole.rfind('>') + 1));
      for (unsigned bit = 0; bit < 8; ++bit) {
        std::string content = whole;
        content[at] = static_cast<char>(static_cast<unsigned char>(content[at]) ^ (1U << bit));
        check_sound(package(content), "m.3mf");
      }
    }
  }
}

TEST_CASE("hostile: changed, doubled and lost bytes are read or refused") {
  std::mt19937_64 random(17);
  const auto pick = [&](std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); };
  constexpr char kInteresting[] = "\0\xFF\x7F\x80 \n\r\\/-+.eE09,[]{}\":#";
  for (const SmallFile& sample : small_files()) {
    CAPTURE(sample.name);
    for (int round = 0; round < 2000; ++round) {
      std::string content = sample.content;
      for (std::size_t changes = 1 + pick(4); changes > 0; --changes) {
        const std::size_t at = pick(content.size());
        switch (pick(4)) {
          case 0:
            content[at] = static_cast<char>(pick(256));
            break;
          case 1:
            content[at] = kInteresting[pick(sizeof kInteresting)];
            break;
          case 2:
            content.erase(at, 1 + pick(8));
            break;
          default:
            content.insert(at, content.substr(pick(content.size()), pick(32)));
        }
        if (content.empty()) break;
      }
      check_sound(content, sample.name);
    }
  }
}

TEST_CASE("hostile: every content under every name") {
  for (const SmallFile& content : small_files()) {
    for (const SmallFile& name : small_files()) check_sound(content.content, name.name);
    check_sound(content.content, "");
  }
}

}  // namespace meshgauge::api::test
