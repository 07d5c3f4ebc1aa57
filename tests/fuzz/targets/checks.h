// What the fuzz targets assert with, and the dice by which they vary what they do.
#pragma once

#include <algorithm>
#include <string_view>

#include "api/base/problem.h"
#include "tests/fuzz/dice.h"

namespace meshgauge::fuzz {

// Ends the program, with `what` and `details` on stderr, when it does not hold.
void require(bool holds, const char* what, std::string_view details = {});

// A refusal that can be sent: valid JSON that says something, and no fault of ours.
void require_answer(const api::Problem& problem);
void require_answer(const Error& error);

// Dice that depend on the bytes alone, so that an input is treated the same way each time.
Dice dice_of(std::string_view bytes);

// Hands the bytes to take(piece) in pieces of 1 to `longest` bytes until it returns false.
template <class Take>
void in_pieces(std::string_view bytes, std::size_t longest, Dice& dice, Take take) {
  while (!bytes.empty()) {
    const std::size_t length = 1 + dice.below(static_cast<std::uint32_t>(longest));
    if (!take(bytes.substr(0, length))) return;
    bytes.remove_prefix(std::min(length, bytes.size()));
  }
}

}  // namespace meshgauge::fuzz
