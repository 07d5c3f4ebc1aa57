// SQL that is joined at compile time from literals and named pieces:
//   constexpr auto kFind = "SELECT " + kJobColumns + " FROM jobs";
// Define it at namespace scope: prepared statements refer to the text. Parameters are $1, $2, ... for both databases.
#pragma once

#include <algorithm>
#include <cstddef>

namespace meshgauge::server::store {

template <std::size_t kSize>
struct Sql {
  char text[kSize + 1] = {};

  constexpr Sql() = default;
  constexpr explicit Sql(const char (&literal)[kSize + 1]) { std::copy_n(literal, kSize + 1, text); }
  constexpr operator const char*() const& { return text; }  // NOLINT(google-explicit-constructor)
  operator const char*() const&& = delete;
};
template <std::size_t kBytes>
Sql(const char (&)[kBytes]) -> Sql<kBytes - 1>;

template <std::size_t kFirst, std::size_t kSecond>
constexpr Sql<kFirst + kSecond> operator+(const Sql<kFirst>& first, const Sql<kSecond>& second) {
  Sql<kFirst + kSecond> joined;
  std::copy_n(first.text, kFirst, joined.text);
  std::copy_n(second.text, kSecond, joined.text + kFirst);
  return joined;
}
template <std::size_t kFirst, std::size_t kBytes>
constexpr auto operator+(const Sql<kFirst>& first, const char (&second)[kBytes]) {
  return first + Sql(second);
}
template <std::size_t kBytes, std::size_t kSecond>
constexpr auto operator+(const char (&first)[kBytes], const Sql<kSecond>& second) {
  return Sql(first) + second;
}

}  // namespace meshgauge::server::store
