// Pictures as pixels: what is drawn over them, and PNG.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "check/html/camera.h"

namespace meshgauge::check {

using Pixel = std::array<std::uint8_t, 4>;  // red, green, blue, alpha

struct Image {
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> rgba;  // rows from the top; transparent where there is nothing

  std::size_t at(int x, int y) const {
    return 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x));
  }
};

// 64 levels: a third smaller when compressed than 256, without a visible difference.
std::uint8_t to_level(double channel);

Image blank_image(int width, int height, const Pixel& colour);

// Lays the colour over an opaque pixel of the image; `share` within [0, 1] is multiplied with the colour's alpha.
void lay_over(Image& image, std::size_t at, const Pixel& colour, double share);

// A ring with four arms around a point, with a casing that shows it on any background. Precondition: the image is
// opaque.
void draw_mark(Image& image, const Seen& at);

// Writes a word in letters of kLetterHeight pixels, its upper left corner at x, y; in one colour. Letters are those of
// "before", "after" and "difference"; any other is a blank. Precondition: the word lies within the image.
constexpr int kLetterHeight = 14;
void write_word(Image& image, int x, int y, std::string_view word, const Pixel& colour);

std::vector<std::byte> to_png(const Image& image);  // throws std::bad_alloc if memory is short

// A PNG of at most `bytes`, if that is 100 or more: with fewer levels of each colour, then half as large, until it
// fits. Precondition: the image is opaque.
std::vector<std::byte> to_png_within(const Image& image, std::size_t bytes);

// The same PNG with a text chunk that says what has made it, "Software: meshgauge", and is kMarkBytes larger.
constexpr std::size_t kMarkBytes = 30;
std::vector<std::byte> marked(std::vector<std::byte> png);
// Whether a file that begins so is such a PNG. Its first kMarkedBytes decide.
constexpr std::size_t kMarkedBytes = 33 + kMarkBytes;
bool is_marked(std::span<const std::byte> beginning);

}  // namespace meshgauge::check
