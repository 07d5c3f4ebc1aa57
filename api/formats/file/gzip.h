// Expands gzip-compressed files.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "api/formats/format.h"

namespace meshgauge::api {

bool is_gzip(std::span<const std::byte> bytes);

struct Freed {
  void operator()(std::byte* p) const { std::free(p); }
};

struct Expanded {
  std::unique_ptr<std::byte, Freed> data;
  std::size_t size = 0;
  std::span<const std::byte> bytes() const { return {data.get(), size}; }
};

// Checks the first expanded bytes before the rest is expanded; an Error ends the expansion.
using FirstLook = std::function<std::optional<Error>(std::span<const std::byte> beginning)>;

// Expands all members. Refuses a truncated or damaged file (CRC and length are checked), bytes after the last member,
// and more than expansion_limit() bytes.
Result<Expanded> expand_gzip(std::span<const std::byte> bytes, std::string_view part, const ReadLimits& limits,
                             const FirstLook& first_look);

}  // namespace meshgauge::api
