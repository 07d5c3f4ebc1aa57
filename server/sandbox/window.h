// The shared memory through which a worker's arrays come to the server: a few slots that are filled and emptied in
// turn. A mesh of any size passes through the same small memory, which stays in the processor's cache, and the server
// has its own copy of every byte before it checks any.
//
// With its Reply a worker has filled the first kSlots pieces, or all. For each further piece the server sends that a
// slot is empty, and the worker that it is filled again: the same short message (kTurn), so that their number carries
// the meaning.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <utility>

#include "api/base/memory_file.h"

namespace meshgauge::server::sandbox {

inline constexpr std::size_t kSlotBytes = std::size_t{256} << 10;
inline constexpr std::uint64_t kSlots = 4;
inline constexpr std::size_t kWindowBytes = kSlots * kSlotBytes;
inline constexpr char kTurn[] = ".";  // message that passes a slot on

inline std::size_t slot_of(std::uint64_t piece) { return static_cast<std::size_t>(piece % kSlots) * kSlotBytes; }

// Calls visit(number, bytes) for each piece of the arrays. Stops and returns false when visit does.
template <class Byte, class Visit>
bool for_each_piece(std::initializer_list<std::span<Byte>> arrays, Visit visit) {
  std::uint64_t number = 0;
  for (std::span<Byte> rest : arrays) {
    while (!rest.empty()) {
      const auto piece = rest.first(std::min(rest.size(), kSlotBytes));
      if (!visit(number, piece)) return false;
      ++number;
      rest = rest.subspan(piece.size());
    }
  }
  return true;
}

inline std::uint64_t count_pieces(std::initializer_list<std::uint64_t> bytes_of_arrays) {
  std::uint64_t count = 0;
  for (const std::uint64_t bytes : bytes_of_arrays) count += (bytes + kSlotBytes - 1) / kSlotBytes;
  return count;
}

// The server's end. Mapped if the size of the file is sealed, since a shortened mapping would end the server;
// otherwise it is read.
class Window {
 public:
  static std::optional<Window> open();  // nullopt: memory or descriptors ran out

  Window(Window&& other) noexcept;
  Window& operator=(Window&& other) noexcept;
  ~Window();

  int file() const { return sized_.file.get(); }

  // Copies the beginning of a slot, which a worker may change meanwhile. False: the file was shortened.
  bool copy(std::uint64_t piece, std::span<std::byte> to) const;

 private:
  Window(SizedFile sized, const std::byte* start) : sized_(std::move(sized)), start_(start) {}

  SizedFile sized_;
  const std::byte* start_;  // null: not mapped
};

}  // namespace meshgauge::server::sandbox
