// Dyadic: exact numbers mantissa * 2^exponent with integers of any size. Every finite double is one, and so are sums,
// differences and products. Ratio: a quotient of two Dyadics.
#pragma once

#include <cmath>
#include <compare>
#include <cstdint>

#include <gmpxx.h>

namespace meshgauge::oracle {

class Dyadic {
 public:
  Dyadic() = default;
  Dyadic(double x);  // NOLINT(google-explicit-constructor): exact. Precondition: finite.

  static Dyadic power_of_two(long exponent) { return Dyadic(1, exponent); }

  int sign() const { return sgn(mantissa_); }
  double approximate() const { return approximate(0); }  // truncated; overflows to infinity, underflows to 0
  // The same for this * 2^exponent, without intermediate overflow.
  double approximate(long exponent) const;
  // The exponent n of the leading bit: 2^(n-1) <= |x| < 2^n. Precondition: not 0.
  long magnitude() const { return static_cast<long>(mpz_sizeinbase(mantissa_.get_mpz_t(), 2)) + exponent_; }
  Dyadic half() const { return Dyadic(mantissa_, exponent_ - 1); }

  friend Dyadic operator+(const Dyadic& a, const Dyadic& b) {
    if (a.exponent_ <= b.exponent_) return Dyadic(a.mantissa_ + b.shifted(a.exponent_), a.exponent_);
    return Dyadic(a.shifted(b.exponent_) + b.mantissa_, b.exponent_);
  }
  friend Dyadic operator-(const Dyadic& a) { return Dyadic(-a.mantissa_, a.exponent_); }
  friend Dyadic operator-(const Dyadic& a, const Dyadic& b) {
    if (a.exponent_ <= b.exponent_) return Dyadic(a.mantissa_ - b.shifted(a.exponent_), a.exponent_);
    return Dyadic(a.shifted(b.exponent_) - b.mantissa_, b.exponent_);
  }
  friend Dyadic operator*(const Dyadic& a, const Dyadic& b) {
    return Dyadic(a.mantissa_ * b.mantissa_, a.exponent_ + b.exponent_);
  }
  friend std::strong_ordering operator<=>(const Dyadic& a, const Dyadic& b) { return (a - b).sign() <=> 0; }
  friend bool operator==(const Dyadic& a, const Dyadic& b) { return std::is_eq(a <=> b); }

 private:
  Dyadic(mpz_class mantissa, long exponent) : mantissa_(std::move(mantissa)), exponent_(exponent) {}

  // Returns the mantissa of the same number at a smaller or equal exponent.
  mpz_class shifted(long exponent) const {
    return mantissa_ << static_cast<mp_bitcnt_t>(sgn(mantissa_) == 0 ? 0 : exponent_ - exponent);
  }

  mpz_class mantissa_;
  long exponent_ = 0;
};

struct Ratio {
  Dyadic numerator;
  Dyadic denominator = 1.0;  // > 0

  // The rounded square root, for messages and for orderings that need not be exact.
  double approximate_root() const;

  friend std::strong_ordering operator<=>(const Ratio& a, const Ratio& b) {
    return a.numerator * b.denominator <=> b.numerator * a.denominator;
  }
  friend bool operator==(const Ratio& a, const Ratio& b) { return std::is_eq(a <=> b); }
};

}  // namespace meshgauge::oracle
