#include "server/sandbox/window.h"

#include <unistd.h>

#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge::server::sandbox;

TEST_CASE("window: two arrays travel in pieces that fit a slot, one after the other") {
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}, kSlotBytes, kSlotBytes + 1, 3 * kSlotBytes}) {
    for (const std::size_t second : {std::size_t{0}, std::size_t{7}, 2 * kSlotBytes - 1}) {
      const std::vector<char> a(first, 'a');
      const std::vector<char> b(second, 'b');
      std::string come;
      std::uint64_t pieces = 0;
      CHECK(for_each_piece({std::span(a), std::span(b)}, [&](std::uint64_t number, std::span<const char> piece) {
        CHECK(number == pieces++);
        CHECK(piece.size() <= kSlotBytes);
        come.append(piece.data(), piece.size());
        return true;
      }));
      CHECK(come == std::string(first, 'a') + std::string(second, 'b'));
      CHECK(count_pieces({first, second}) == pieces);
    }
  }
}

TEST_CASE("window: the transfer ends with the first missing piece") {
  const std::vector<char> array(5 * kSlotBytes);
  std::uint64_t pieces = 0;
  CHECK(!for_each_piece({std::span(array), std::span(array)}, [&](auto...) { return ++pieces < 3; }));
  CHECK(pieces == 3);
}

TEST_CASE("window: a slot holds what was written into it") {
  const auto window = Window::open();
  REQUIRE(window);
  for (std::uint64_t piece = 0; piece < 2 * kSlots; ++piece) {
    const std::string text = "piece " + std::to_string(piece);
    REQUIRE(::pwrite(window->file(), text.data(), text.size(), static_cast<off_t>(slot_of(piece))) > 0);
    std::string copy(text.size(), '?');
    REQUIRE(window->copy(piece, std::as_writable_bytes(std::span(copy))));
    CHECK(copy == text);
  }
  CHECK(::ftruncate(window->file(), 0) != 0);
}
