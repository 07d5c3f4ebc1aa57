// Result<T>: a value, or an Error that names the defect. The only way a failure crosses a border
// between the libraries; exceptions end at the job's edge.
#pragma once

#include <cassert>
#include <string>
#include <utility>
#include <variant>

namespace meshgauge {

// What went wrong, in the words of a caller. api/problem.h gives each its HTTP status.
enum class ErrorCode {
  invalid_request,       // options, parts or flags that cannot be understood
  unsupported_format,    // a file of a kind, version or extension that is not read
  unreadable_mesh,       // malformed file: truncated, bad number, bad reference
  empty_mesh,            // no triangle at all
  non_finite_vertex,     // NaN or infinity in a coordinate
  index_out_of_range,    // a face names a vertex that does not exist
  coordinate_too_large,  // beyond kMaxCoordinate: distances could overflow
  too_large,             // over a stated limit of bytes, vertices or triangles
  out_of_time,           // the deadline passed before there was anything to bound
  storage_full,          // what is to be kept finds no room; passes by itself when there is some
  storage_unavailable,   // it cannot be written or read: a read-only disk, an I/O error, a lock; may pass
  internal,              // our own bug, or the machine's failure (a file that cannot be opened)
};

struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;  // complete sentence fragment for people: "vertex 17 of 'a' is NaN"
  std::string part;     // which input: "a", "b", "options"; empty when none is to blame
  std::string where;    // "line 12", "byte 84", "accessor 3", "triangle 7"; empty when unknown
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
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

  Error& error() & { return assert(!ok()), *std::get_if<1>(&state_); }
  const Error& error() const& { return assert(!ok()), *std::get_if<1>(&state_); }
  Error&& error() && { return assert(!ok()), std::move(*std::get_if<1>(&state_)); }

 private:
  std::variant<T, Error> state_;
};

// For calls that return nothing: Result<Done>.
struct Done {};

}  // namespace meshgauge
