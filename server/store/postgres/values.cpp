#include "server/store/postgres/values.h"

#include <bit>
#include <cassert>
#include <cstring>

#include <libpq-fe.h>

namespace meshgauge::server::store {
namespace {

// PostgreSQL's numbers of its types (pg_type.dat), which never change.
constexpr unsigned kBool = 16, kBytea = 17, kInt8 = 20, kInt2 = 21, kInt4 = 23, kFloat8 = 701;
constexpr unsigned kByteaArray = 1001, kInt8Array = 1016, kFloat8Array = 1022;

template <class Unsigned>
void append(std::string& bytes, Unsigned number) {
  for (int shift = static_cast<int>(sizeof(number)) * 8 - 8; shift >= 0; shift -= 8) {
    bytes.push_back(static_cast<char>((number >> shift) & 0xff));
  }
}

std::uint64_t read_number(std::string_view bytes) {
  std::uint64_t number = 0;
  for (const char c : bytes) number = number << 8 | static_cast<unsigned char>(c);
  return number;
}

std::string bytes_of(std::int64_t number) {
  std::string bytes;
  append(bytes, static_cast<std::uint64_t>(number));
  return bytes;
}
std::string bytes_of(double real) { return bytes_of(std::bit_cast<std::int64_t>(real)); }
const std::string& bytes_of(const std::string& text) { return text; }

template <class T>
const T* value_of(const std::optional<T>& value) {
  return value ? &*value : nullptr;
}
template <class T>
const T* value_of(const T& value) {
  return &value;
}

// Number of dimensions, flag for nulls, type; length and lower bound of the dimension; then each element after its
// length.
template <class T>
std::string array_of(unsigned type, const std::vector<T>& elements) {
  std::string bytes;
  append(bytes, std::uint32_t{1});
  append(bytes, std::uint32_t{1});
  append(bytes, static_cast<std::uint32_t>(type));
  append(bytes, static_cast<std::uint32_t>(elements.size()));
  append(bytes, std::uint32_t{1});
  for (const T& element : elements) {
    const auto* value = value_of(element);
    if (value == nullptr) {
      append(bytes, ~std::uint32_t{0});
      continue;
    }
    const std::string& sent = bytes_of(*value);
    append(bytes, static_cast<std::uint32_t>(sent.size()));
    bytes += sent;
  }
  return bytes;
}

}  // namespace

void PgValues::add(unsigned type, std::string bytes) {
  types_.push_back(type);
  values_.emplace_back(std::move(bytes));
}

void PgValues::add(std::string_view text) { add(kBytea, std::string(text)); }
void PgValues::add(std::span<const std::byte> bytes) {
  add(kBytea, std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}
void PgValues::add(double real) { add(kFloat8, bytes_of(real)); }
void PgValues::add(bool flag) { add(kBool, std::string(1, flag ? '\1' : '\0')); }
void PgValues::add(std::int64_t number) { add(kInt8, bytes_of(number)); }
void PgValues::add(const std::vector<std::string>& texts) { add(kByteaArray, array_of(kBytea, texts)); }
void PgValues::add(const std::vector<std::optional<std::string>>& texts) { add(kByteaArray, array_of(kBytea, texts)); }
void PgValues::add(const std::vector<std::int64_t>& numbers) { add(kInt8Array, array_of(kInt8, numbers)); }
void PgValues::add(const std::vector<std::optional<std::int64_t>>& numbers) {
  add(kInt8Array, array_of(kInt8, numbers));
}
void PgValues::add(const std::vector<std::optional<double>>& reals) { add(kFloat8Array, array_of(kFloat8, reals)); }

std::vector<const char*> PgValues::pointers() const {
  std::vector<const char*> pointers;
  for (const auto& value : values_) pointers.push_back(value ? value->data() : nullptr);
  return pointers;
}

std::vector<int> PgValues::lengths() const {
  std::vector<int> lengths;
  for (const auto& value : values_) lengths.push_back(value ? static_cast<int>(value->size()) : 0);
  return lengths;
}

void PgRows::Cleared::operator()(pg_result* result) const { PQclear(result); }

int PgRows::size() const { return PQntuples(result_.get()); }

std::uint64_t PgRows::changed() const {
  const char* number = PQcmdTuples(result_.get());
  return *number == '\0' ? 0 : std::stoull(number);
}

bool PgRows::is_null(int column) const { return PQgetisnull(result_.get(), row_, column) != 0; }

std::string_view PgRows::bytes(int column) const {
  return {PQgetvalue(result_.get(), row_, column), static_cast<std::size_t>(PQgetlength(result_.get(), row_, column))};
}

std::int64_t PgRows::number(int column) const {
  const std::uint64_t raw = is_null(column) ? 0 : read_number(bytes(column));
  switch (PQftype(result_.get(), column)) {
    case kInt2:
      return static_cast<std::int16_t>(raw);
    case kInt4:
      return static_cast<std::int32_t>(raw);
    default:
      assert(PQftype(result_.get(), column) == kInt8 || PQftype(result_.get(), column) == kBool);
      return static_cast<std::int64_t>(raw);
  }
}

double PgRows::real(int column) const {
  assert(PQftype(result_.get(), column) == kFloat8);
  return std::bit_cast<double>(read_number(bytes(column)));
}

std::string PgRows::text(int column) const { return std::string(bytes(column)); }

std::optional<TimePoint> PgRows::time_if_any(int column) const {
  if (is_null(column)) return std::nullopt;
  return time(column);
}

}  // namespace meshgauge::server::store
