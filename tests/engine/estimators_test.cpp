// The estimators of sampled distances against values computed by hand.
#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "engine/extras/statistics/sampled_distances.h"
#include "engine/statistics.h"

using namespace meshgauge;

TEST_CASE("the estimators agree with values computed by hand") {
  // Two strata: nine times 0 and a 2; half 4, half 6. Their means are 0.2 and 5.
  std::vector<double> values(20, 0);
  values[9] = 2;
  for (std::size_t i = 10; i < 20; ++i) values[i] = i % 2 == 0 ? 4 : 6;
  const Distribution found = summarize(values);
  CHECK(found.samples == 20);
  CHECK(found.mean.value == doctest::Approx(2.6));
  CHECK(found.mean.standard_error == doctest::Approx(std::sqrt((9 * 0.04 + 1.8 * 1.8 + 10) * 10 / 9) / 20));
  CHECK(found.rms.value == doctest::Approx(std::sqrt(13.2)));  // squares: 0.4 and 26 in the mean
  const double of_square = std::sqrt((9 * 0.16 + 3.6 * 3.6 + 10 * 100) * 10 / 9) / 20;
  CHECK(found.rms.standard_error == doctest::Approx(of_square / (2 * std::sqrt(13.2))));
  // All values of one stratum and none of the other are at most 2: one rank, two errors to each side: 0 and 4.
  CHECK(found.p50.value == 2);
  CHECK(found.p50.standard_error == 1);
  CHECK(found.p99.value == 6);
  CHECK(found.max_seen == 6);
  CHECK(found.histogram.front().value == 0.45);
  CHECK(found.histogram.front().standard_error == doctest::Approx(std::sqrt(9.0 / 9 + 1) / 20));
  CHECK(found.histogram[10].value == 0.05);  // 2 of 0 .. 6
  CHECK(found.histogram.back().value == 0.25);
  CHECK(found.histogram.back().standard_error == doctest::Approx(std::sqrt(25.0 / 9 + 1) / 20));
}

TEST_CASE("equal values have no error, and their mean is not above them") {
  for (const double x : {0.0, 0.1, 1e-300}) {
    const Distribution found = summarize(std::vector<double>(1010, x));
    for (const auto estimate :
         {&Distribution::mean, &Distribution::rms, &Distribution::p50, &Distribution::p95, &Distribution::p99}) {
      CHECK((found.*estimate).value == doctest::Approx(x).epsilon(1e-12));
      CHECK((found.*estimate).value <= x);
      CHECK((found.*estimate).standard_error == 0);
    }
    CHECK(found.max_seen == x);
    CHECK(found.histogram[x == 0 ? 0 : Distribution::kBins - 1].value == 1);
  }
}
