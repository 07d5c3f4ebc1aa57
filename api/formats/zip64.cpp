#include "api/formats/zip64.h"

#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>

namespace meshgauge::api {
namespace {

static_assert(std::endian::native == std::endian::little, "zip archives are read as the machine's own integers");

constexpr std::size_t kFixedBytes = 46;
constexpr std::size_t kNameLengthAt = 28;
constexpr std::size_t kExtraLengthAt = 30;
// Places of size, packed size and offset in the record. The Zip64 field has them in this order, each only if its plain
// place holds 0xFFFFFFFF.
constexpr std::size_t kPlacesInOrder[] = {24, 20, 42};
constexpr std::uint32_t kElsewhere = 0xFFFFFFFF;
constexpr std::uint16_t kZip64 = 0x0001;
constexpr std::uint16_t kNoMeaning = 0x0000;

template <class Integer>
Integer integer_at(std::span<const std::byte> bytes, std::size_t at) {
  Integer value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

template <class Integer>
void put(std::span<std::byte> bytes, std::size_t at, Integer value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

// Returns the place of the Zip64 field among the extra fields; nullopt: none.
std::optional<std::size_t> find_zip64(std::span<const std::byte> record, std::size_t at) {
  while (at + 4 <= record.size()) {
    const std::size_t next = at + 4 + integer_at<std::uint16_t>(record, at + 2);
    if (next > record.size()) return std::nullopt;
    if (integer_at<std::uint16_t>(record, at) == kZip64) return at;
    at = next;
  }
  return std::nullopt;
}

// Copies numbers from the Zip64 field to their plain places. false: one is missing or too large.
bool put_in_place(std::span<std::byte> record, std::size_t field) {
  const std::size_t end = field + 4 + integer_at<std::uint16_t>(record, field + 2);
  std::size_t at = field + 4;
  for (const std::size_t place : kPlacesInOrder) {
    if (integer_at<std::uint32_t>(record, place) != kElsewhere) continue;
    if (at + 8 > end) return false;
    const auto value = integer_at<std::uint64_t>(record, at);
    if (value >= kElsewhere) return false;
    put(record, place, static_cast<std::uint32_t>(value));
    at += 8;
  }
  put(record, field, kNoMeaning);
  return true;
}

}  // namespace

std::vector<std::byte> plain_zip_record(std::span<const std::byte> archive, std::size_t at) {
  if (at > archive.size() || archive.size() - at < kFixedBytes) return {};
  const auto rest = archive.subspan(at);
  if (std::memcmp(rest.data(), "PK\x01\x02", 4) != 0) return {};
  bool full = false;
  for (const std::size_t place : kPlacesInOrder) full |= integer_at<std::uint32_t>(rest, place) == kElsewhere;
  const std::size_t extra = kFixedBytes + integer_at<std::uint16_t>(rest, kNameLengthAt);
  const std::size_t bytes = extra + integer_at<std::uint16_t>(rest, kExtraLengthAt);
  if (!full || bytes > rest.size()) return {};
  std::vector<std::byte> record(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(bytes));
  const auto field = find_zip64(record, extra);
  if (!field || !put_in_place(record, *field)) return {};
  return record;
}

}  // namespace meshgauge::api
