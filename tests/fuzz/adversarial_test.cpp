// The pairs of corpus/adversarial, for which published codes crash, hang or return wrong results. Each strategy ends
// within its deadline and a gigabyte, with an interval that the oracle accepts.
#include <doctest/doctest.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "fuzz/attack.h"
#include "today.h"

using namespace meshgauge;
using namespace meshgauge::fuzz;

namespace {

// Deadlines for a pair that must converge, and for one that only needs a valid interval.
constexpr auto kPatience = std::chrono::seconds(10), kLittlePatience = std::chrono::seconds(1);

std::filesystem::path folder() {
  const char* set = std::getenv("MESHGAUGE_CORPUS");
  return std::filesystem::path(set != nullptr ? set : MESHGAUGE_SOURCE_DIR "/../shared/corpus") / "adversarial";
}

// A simple reader of lines `v x y z` and `f i j k`, so that the test does not depend on the product's readers.
Mesh read_obj(const std::filesystem::path& path) {
  std::ifstream file(path);
  REQUIRE(file);
  Mesh mesh;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string kind, x, y, z;
    if (!(words >> kind >> x >> y >> z)) continue;
    const auto number = [](const std::string& s) { return std::strtod(s.c_str(), nullptr); };
    const auto index = [](const std::string& s) { return static_cast<std::uint32_t>(std::stoul(s)) - 1; };
    if (kind == "v") mesh.positions.emplace_back(number(x), number(y), number(z));
    if (kind == "f") mesh.triangles.push_back({index(x), index(y), index(z)});
  }
  return mesh;
}

struct Row {
  std::string name;
  std::optional<double> truth;
  double tolerance = 0;
  std::optional<std::pair<double, double>> bracket;  // by another independent search, rounded
};

std::vector<Row> rows() {
  std::vector<Row> rows;
  std::ifstream file(folder() / "INDEX.tsv");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream columns(line);
    std::string name, what, truth, tolerance, bracket;
    for (std::string* column : {&name, &what, &truth, &tolerance, &bracket}) std::getline(columns, *column, '\t');
    Row row{name, std::nullopt, std::strtod(tolerance.c_str(), nullptr), std::nullopt};
    char* end = nullptr;
    const double value = std::strtod(truth.c_str(), &end);
    if (end != truth.c_str() && *end == '\0') row.truth = value;
    double low = 0, high = 0;
    if (std::sscanf(bracket.c_str(), "[%lf,%lf]", &low, &high) == 2) row.bracket = {low, high};
    if (name == "huge1e155") row.bracket.reset();  // squares overflow in that search
    rows.push_back(row);
  }
  return rows;
}

// Whether A and B are one surface cut differently: no finite set of the paper's certificates proves 0.
bool is_near_coplanar(const std::string& name) {
  return name.find("otherdiag") != std::string::npos || name.find("flatgrid") != std::string::npos ||
         name == "tang_invalid_lower";
}

// Whether the strategy must converge: `auto` always; the paper's if the distance is 0 and the pair is not only nearly
// coplanar.
bool must_converge(const Row& row, Strategy strategy) {
  return strategy == Strategy::automatic || (row.truth == 0.0 && !is_near_coplanar(row.name));
}

void check_end(const Row& row, Strategy strategy, const Outcome& outcome) {
  const bool ran_out = outcome.stop == Stop::timeout || outcome.stop == Stop::budget;
  if (must_converge(row, strategy)) CHECK_FALSE(ran_out);
  if (row.truth == 0.0 && !ran_out) CHECK(outcome.upper <= row.tolerance);
  if (row.truth && *row.truth > 0) {
    CHECK(outcome.lower <= *row.truth * (1 + 1e-12));
    CHECK(outcome.upper >= *row.truth * (1 - 1e-12));
  }
  if (row.bracket) {
    CHECK(outcome.lower <= row.bracket->second * (1 + 1e-9));
    CHECK(outcome.upper >= row.bracket->first * (1 - 1e-9));
  }
}

void check_pair(const Row& row, const Pair& pair) {
  oracle::Judge judge(pair.a, pair.b, {2000, pair.b.triangles.size() < 20 ? std::size_t{30} : std::size_t{0}});
  for (const Method& method : methods()) {
    for (const int points : method.strategy == Strategy::n_point ? std::vector{4, 31} : std::vector{4}) {
      CAPTURE(std::string(method.name));
      CAPTURE(points);
      Attempt attempt;
      attempt.options.strategy = method.strategy;
      attempt.options.points = points;
      attempt.options.direction = Direction::a_to_b;
      attempt.options.tolerance = {row.tolerance, std::nullopt, std::nullopt};
      attempt.options.max_memory_bytes = std::size_t{256} << 20;
      attempt.deadline = must_converge(row, method.strategy) ? kPatience : kLittlePatience;
      const Attacked attacked = attack(pair, attempt, judge);
      CHECK_MESSAGE(!attacked.violation, attacked.violation->check, ": ", attacked.violation->detail);
      check_end(row, method.strategy, attacked.seen.outcome);
    }
  }
}

long peak_kilobytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

}  // namespace

TEST_CASE("every adversarial pair ends with an interval that holds") {
  if (!std::filesystem::exists(folder() / "INDEX.tsv")) {
    MESSAGE("no corpus at ", folder().string());
    return;
  }
  const auto all = rows();
  CHECK(all.size() >= 20);
  std::uint64_t number = 0;
  for (const Row& row : all) {
    if (!is_of_today(number++, 2)) continue;
    CAPTURE(row.name);
    const Pair pair{read_obj(folder() / (row.name + "_a.obj")), read_obj(folder() / (row.name + "_b.obj")), row.name};
    const bool valid = validate(pair.a, {}, "a").ok() && validate(pair.b, {}, "b").ok();
    CHECK(valid == (row.name != "inf_B"));
    if (valid) check_pair(row, pair);
  }
  if (!MESHGAUGE_SANITIZED) CHECK(peak_kilobytes() < 1'000'000);  // a sanitizer's shadow counts, too
}
