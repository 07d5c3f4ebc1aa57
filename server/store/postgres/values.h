// Values in PostgreSQL's binary formats. Text is `bytea`: any bytes come back unchanged, also NUL and bytes that are
// not UTF-8, and are compared byte by byte.
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

// The parameters $1, $2, ... of one statement. Real numbers are sent as float8, integers as int8.
class PgValues {
 public:
  template <class... Values>
  explicit PgValues(const Values&... values) {
    (add(values), ...);
  }

  int size() const { return static_cast<int>(types_.size()); }
  const unsigned* types() const { return types_.data(); }
  // Valid until this object changes.
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

// The rows that a statement returned; next() moves to the first one.
class PgRows {
 public:
  explicit PgRows(pg_result* result) : result_(result) {}

  bool next() { return ++row_ < size(); }
  int size() const;
  std::uint64_t changed() const;  // number of rows that an INSERT, UPDATE or DELETE changed

  bool is_null(int column) const;
  std::int64_t number(int column) const;  // of any integer type, or a boolean
  double real(int column) const;
  std::string text(int column) const;
  std::string_view bytes(int column) const;  // valid while this object lives
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
