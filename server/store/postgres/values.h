// Values on their way to PostgreSQL and back, in its binary formats. Text of any bytes, NUL and what is not UTF-8
// included, is `bytea`: it comes back as it was, and is compared byte by byte.
#pragma once

#include <concepts>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "server/store/job_store.h"

struct pg_result;  // libpq's PGresult

namespace meshgauge::server::store {

// The parameters of one statement, $1 and so on in the order given. `real` and `number` are sent as float8 and int8.
class PgValues {
 public:
  template <class... Values>
  explicit PgValues(const Values&... values) {
    (add(values), ...);
  }

  int size() const { return static_cast<int>(types_.size()); }
  const unsigned* types() const { return types_.data(); }
  // Valid as long as this object is left as it is.
  std::vector<const char*> pointers() const;
  std::vector<int> lengths() const;

 private:
  void add(std::string_view text);
  void add(const std::string& text) { add(std::string_view(text)); }
  void add(const char* text) { add(std::string_view(text)); }
  void add(std::span<const std::byte> bytes);
  void add(double real);
  void add(bool flag);
  void add(std::int64_t number);
  void add(std::integral auto number) { add(static_cast<std::int64_t>(number)); }
  void add(JobState state) { add(static_cast<std::int64_t>(state)); }
  void add(TimePoint time) { add(static_cast<std::int64_t>(time.time_since_epoch().count())); }
  void add(const std::vector<std::string>& texts);
  void add(const std::vector<std::optional<std::string>>& texts);
  void add(const std::vector<std::int64_t>& numbers);
  void add(const std::vector<std::optional<std::int64_t>>& numbers);
  void add(const std::vector<std::optional<double>>& reals);
  template <class T>
  void add(const std::optional<T>& value) {
    if (value) return add(*value);
    add(T{});
    values_.back().reset();
  }
  void add(unsigned type, std::string bytes);

  std::vector<unsigned> types_;
  std::vector<std::optional<std::string>> values_;
};

// What a statement answered. Before the first row until next().
class PgRows {
 public:
  explicit PgRows(pg_result* result) : result_(result) {}

  bool next() { return ++row_ < size(); }
  int size() const;
  std::uint64_t changed() const;  // rows that an INSERT, UPDATE or DELETE touched

  bool is_null(int column) const;
  std::int64_t number(int column) const;  // of any integer type, or a boolean
  double real(int column) const;
  std::string text(int column) const;
  std::string_view bytes(int column) const;  // as long as this object lives
  TimePoint time(int column) const { return TimePoint(std::chrono::milliseconds(number(column))); }
  std::optional<TimePoint> time_if_any(int column) const;

 private:
  struct Cleared {
    void operator()(pg_result* result) const;
  };
  std::unique_ptr<pg_result, Cleared> result_;
  int row_ = -1;
};

}  // namespace meshgauge::server::store
