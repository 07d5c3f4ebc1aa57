#include "oracle/dyadic.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <climits>

namespace meshgauge::oracle {

Dyadic::Dyadic(double x) {
  assert(std::isfinite(x));
  if (x == 0) return;
  int exponent = 0;
  const auto mantissa = static_cast<std::int64_t>(std::ldexp(std::frexp(x, &exponent), 53));  // an integer: exact
  const int zeros = std::countr_zero(static_cast<std::uint64_t>(mantissa));                   // -m has as many as m
  mantissa_ = static_cast<long>(mantissa >> zeros);
  exponent_ = exponent - 53 + zeros;
}

double Dyadic::approximate(long exponent) const {
  long own = 0;
  const double fraction = mpz_get_d_2exp(&own, mantissa_.get_mpz_t());
  return std::ldexp(fraction, static_cast<int>(std::clamp(own + exponent_ + exponent, -100'000L, 100'000L)));
}

double Ratio::approximate_root() const {
  if (numerator.sign() == 0) return 0;
  // Takes out an even power of two first, so that the root overflows or underflows only if it must.
  const long half = (numerator.magnitude() - denominator.magnitude()) / 2;
  const double quotient =
      numerator.approximate(-numerator.magnitude()) / denominator.approximate(-denominator.magnitude());
  const long rest = numerator.magnitude() - denominator.magnitude() - 2 * half;
  return std::ldexp(std::sqrt(std::ldexp(quotient, static_cast<int>(rest))), static_cast<int>(half));
}

}  // namespace meshgauge::oracle
