// Bytes and their names, for tests.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include <doctest/doctest.h>

#include "api/base/digest.h"
#include "server/store/blob_store.h"

namespace meshgauge::server::store {

// Returns the value, or fails the test with the error's message.
template <class T>
T got(Result<T> result) {
  if (!result) FAIL(result.error().message);
  return std::move(*result);
}

inline std::span<const std::byte> bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::byte*>(text.data()), text.size()};
}

inline BlobKey key_of(const std::string& owner, std::string_view content) {
  return {owner, api::sha256_hex(bytes_of(content))};
}

inline std::string text_of(const Blob& blob) {
  return {reinterpret_cast<const char*>(blob.bytes().data()), blob.bytes().size()};
}

inline std::string long_text(std::size_t size) {
  std::string text(size, '\0');
  for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i * i >> 7);
  return text;
}

}  // namespace meshgauge::server::store
