// Every file of the corpus: accepted or refused as its INDEX.tsv asks for, with the same surface where it names one.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "tests/api/formats/files.h"

namespace meshgauge::api::test {
namespace {

// Files whose answer differs from the index: a piece of the message, or "" if accepted. docs/formats.md gives the
// reasons.
const std::map<std::string, std::string> kOtherAnswers = {
    {"real/number_formats.obj", "'3.1+e2' is not a number"}, {"real/badNumber.gltf", ""}, {"real/badString.gltf", ""}};

Result<ReadMesh> read_file(const std::filesystem::path& path) {
  return read(bundled_content(path), path.filename().string());
}

using FacetCorners = std::array<double, 9>;

// The three corners rotated so that the least is first: the same for each rotation of a triangle.
FacetCorners told_from_least(const Mesh& mesh, const Triangle& triangle) {
  std::array<FacetCorners, 3> turns;
  for (std::size_t turn = 0; turn < 3; ++turn) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Vec3& p = mesh.positions[triangle[(turn + corner) % 3]];
      for (std::size_t k = 0; k < 3; ++k) turns[turn][3 * corner + k] = p[static_cast<int>(k)];
    }
  }
  return *std::ranges::min_element(turns);
}

bool is_degenerate(const FacetCorners& c) {
  const auto same = [&](std::size_t i, std::size_t j) { return std::equal(&c[i], &c[i] + 3, &c[j]); };
  return same(0, 3) || same(3, 6) || same(0, 6);
}

std::vector<FacetCorners> surface(const Mesh& mesh) {
  std::vector<FacetCorners> triangles;
  for (const Triangle& triangle : mesh.triangles) {
    const FacetCorners corners = told_from_least(mesh, triangle);
    if (!is_degenerate(corners)) triangles.push_back(corners);
  }
  return triangles;
}

double distance(const FacetCorners& a, const FacetCorners& b) {
  double most = 0;
  for (std::size_t k = 0; k < 9; ++k) most = std::max(most, std::abs(a[k] - b[k]));
  return most;
}

// Rounded coordinates may rotate and sort otherwise, so each triangle searches its nearest, in any rotation.
double difference(const std::vector<FacetCorners>& a, const std::vector<FacetCorners>& b) {
  double most = 0;
  for (const FacetCorners& triangle : a) {
    double nearest = std::numeric_limits<double>::infinity();
    for (FacetCorners other : b) {
      for (int turn = 0; turn < 3; ++turn) {
        nearest = std::min(nearest, distance(triangle, other));
        std::ranges::rotate(other, other.begin() + 3);
      }
    }
    most = std::max(most, nearest);
  }
  return most;
}

double tolerance(const std::string& told, double size) {
  char* end = nullptr;
  const double number = std::strtod(told.c_str(), &end);
  if (end != told.c_str() && *end == '\0') return number;
  if (contains(told, "1e-9")) return 1e-9 * size;
  if (contains(told, "after the shift")) return 0x1p-19 * size;
  return 0x1p-21 * size;  // some kind of float32 rounding
}

void check_same_surface(const std::filesystem::path& folder, const std::string& other, const std::string& told,
                        const Mesh& mesh) {
  auto reference = read_file(folder / other);
  REQUIRE(reference.ok());
  double size = 0;
  for (const Vec3& p : reference->mesh.positions) size = std::max(size, p.lpNorm<Eigen::Infinity>());
  const auto a = surface(mesh);
  const auto b = surface(reference->mesh);
  CHECK(a.size() == b.size());
  const double allowed = tolerance(told, size);
  CHECK(difference(a, b) <= allowed);
  CHECK(difference(b, a) <= allowed);
}

std::size_t triangles_told(const std::string& expected) {
  const std::size_t at = expected.find(" triangles");
  if (at == std::string::npos || at == 0 || std::isdigit(static_cast<unsigned char>(expected[at - 1])) == 0) return 0;
  std::size_t first = at;
  while (first > 0 && std::isdigit(static_cast<unsigned char>(expected[first - 1])) != 0) --first;
  return std::stoul(expected.substr(first, at - first));
}

// The kind of answer that the index asks for.
bool may_accept(const std::string& answer) {
  return contains(answer, "accept") || contains(answer, "documented choice") || contains(answer, "finite answer");
}
bool may_refuse(const std::string& answer) { return contains(answer, "422") || contains(answer, "413"); }

void check_refusal(const Error& error) {
  CHECK(error.part == "a");
  CHECK(contains(error.message, "'a'"));
  CHECK(error.message.size() > 10);
  CHECK(error.code != ErrorCode::internal);
  CHECK(std::ranges::all_of(error.message, [](char c) { return c >= ' ' && c <= '~'; }));
}

void check_row(const std::string& file, const std::string& answer, const Result<ReadMesh>& result) {
  const std::string message = result ? "" : result.error().message;
  if (!result) check_refusal(result.error());
  const auto other = kOtherAnswers.find(file);
  if (other != kOtherAnswers.end()) {
    MESSAGE("other answer: " << (result ? "accepted" : message) << "; asked for: " << answer);
    CHECK(result.ok() == other->second.empty());
    CHECK(contains(message, other->second));
    return;
  }
  const bool cloud = result && result->notes.cloud && contains(answer, "no triangles");  // the index is about surfaces
  CHECK_MESSAGE((cloud || (result ? may_accept(answer) : may_refuse(answer))), message << "; asked for: " << answer);
}

}  // namespace

TEST_CASE("corpus: good files are read as the index says") {
  const auto root = corpus();
  if (!root) return;
  const auto folder = *root / "formats";
  for (const auto& row : table(folder / "INDEX.tsv")) {
    if (contains(row.at(2), "not an input")) continue;
    CAPTURE(row.at(0));
    const auto result = read_file(folder / row[0]);
    check_row(row[0], row.at(2), result);
    if (!result) continue;
    const std::size_t told = triangles_told(row[2]);
    if (told != 0) CHECK(surface(result->mesh).size() == told);
    if (row.size() > 5 && !row[4].empty()) check_same_surface(folder, row[4], row[5], result->mesh);
  }
}

TEST_CASE("corpus: malformed files are refused, or accepted where the index says so") {
  const auto root = corpus();
  if (!root) return;
  for (const auto& row : table(*root / "malformed" / "INDEX.tsv")) {
    CAPTURE(row.at(0));
    check_row(row[0], row.at(2), read_file(*root / "malformed" / row[0]));
  }
}

TEST_CASE("corpus: every mesh of the comparison sets is read") {
  const auto root = corpus();
  if (!root) return;
  for (const char* folder : {"meshes", "adversarial"}) {
    for (const auto& entry : std::filesystem::directory_iterator(*root / folder)) {
      if (entry.path().extension() == ".tsv" || entry.file_size() > 4'000'000) continue;
      CAPTURE(entry.path().string());
      const auto result = read_file(entry.path());
      CHECK(result.ok() == (entry.path().filename() != "inf_B_b.obj"));  // holds an infinite coordinate
    }
  }
}

}  // namespace meshgauge::api::test
