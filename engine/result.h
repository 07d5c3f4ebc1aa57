// Result<T>: a value, or an Error that names the defect. Failures cross the borders between the libraries only as
// Results; exceptions end at the job's edge.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace meshgauge {

// The kind of a failure. api/base/problem.h gives each its HTTP status.
enum class ErrorCode {
  invalid_request,       // options, parts or flags that cannot be understood
  unit_conflict,         // the units of a limit and two meshes contradict each other, or one is unknown
  unsupported_format,    // a file's format, version or extension is not supported
  unreadable_mesh,       // malformed file: truncated, bad number, bad reference
  empty_mesh,            // no triangle
  non_finite_vertex,     // NaN or infinity in a coordinate
  index_out_of_range,    // a face names a vertex that does not exist
  coordinate_too_large,  // beyond kMaxCoordinate: distances could overflow
  too_large,             // over a stated limit of bytes, vertices or triangles
  out_of_time,           // the deadline passed before there was an interval
  storage_full,          // the store has no room; may succeed later
  storage_unavailable,   // the store cannot be read or written: read-only disk, I/O error, lock; may succeed later
  storage_damaged,       // what the store has written was changed by others, or lost by its disk: to be mended
  internal,              // a bug, or a failure of the machine (a file that cannot be opened)
};

struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;          // for users: names the defect, "vertex 17 of 'a' is NaN"
  std::string part;             // the input at fault: "a", "b", "options"; empty: none
  std::string where;            // "line 12", "byte 84", "accessor 3", "triangle 7"; empty: unknown
  std::vector<Error> others{};  // further defects of the same input; they have no others
};

template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}      // NOLINT(google-explicit-constructor)
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}  // NOLINT(google-explicit-constructor)

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }

  T& value() & { return assert(ok()), *std::get_if<0>(&state_); }
  const T& value() const& { return assert(ok()), *std::get_if<0>(&state_); }
  T&& value() && { return assert(ok()), std::move(*std::get_if<0>(&state_)); }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T&& operator*() && { return std::move(*this).value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  Error& error() & { return assert(!ok()), *std::get_if<1>(&state_); }
  const Error& error() const& { return assert(!ok()), *std::get_if<1>(&state_); }
  Error&& error() && { return assert(!ok()), std::move(*std::get_if<1>(&state_)); }

 private:
  std::variant<T, Error> state_;
};

// The value of a call that returns nothing: Result<Done>.
struct Done {};

}  // namespace meshgauge
