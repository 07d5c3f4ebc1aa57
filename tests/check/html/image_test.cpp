#include "check/html/image.h"

#include <png.h>
#include <cstddef>
#include <cstdint>
#include <random>
#include <span>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::check;

namespace {

constexpr Pixel kWhite{255, 255, 255, 255}, kBlack{0, 0, 0, 255};

Image read_back(std::span<const std::byte> bytes) {
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  REQUIRE(png_image_begin_read_from_memory(&png, bytes.data(), bytes.size()) != 0);
  png.format = PNG_FORMAT_RGBA;
  Image image{static_cast<int>(png.width), static_cast<int>(png.height), {}};
  image.rgba.resize(PNG_IMAGE_SIZE(png));
  REQUIRE(png_image_finish_read(&png, nullptr, image.rgba.data(), 0, nullptr) != 0);
  return image;
}

// Such that no compression helps.
Image noise(int width, int height) {
  Image image = blank_image(width, height, kWhite);
  std::mt19937 random(1);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(random() & 255U);
  }
  return image;
}

std::size_t count_of(const Image& image, const Pixel& colour) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    count += Pixel{image.rgba[i], image.rgba[i + 1], image.rgba[i + 2], image.rgba[i + 3]} == colour ? 1U : 0U;
  }
  return count;
}

}  // namespace

TEST_CASE("a PNG reads back as the picture that was written, opaque or not") {
  for (const std::uint8_t alpha : {std::uint8_t{255}, std::uint8_t{7}}) {
    Image image{3, 2, {}};
    for (int i = 0; i < 24; ++i) image.rgba.push_back(static_cast<std::uint8_t>(i % 4 == 3 ? 255 : 9 * i));
    image.rgba[3] = alpha;
    const Image back = read_back(to_png(image));
    CHECK(back.width == 3);
    CHECK(back.height == 2);
    CHECK(back.rgba == image.rgba);
  }
}

TEST_CASE("a PNG gets as small as it must be: first coarser, then half as large") {
  const Image image = noise(200, 100);
  const std::size_t whole = to_png(image).size();
  CHECK(to_png_within(image, whole) == to_png(image));
  const auto coarser = to_png_within(image, whole * 3 / 4);
  CHECK(coarser.size() <= whole * 3 / 4);
  CHECK(read_back(coarser).width == 200);
  const auto half = to_png_within(image, whole / 4);
  CHECK(half.size() <= whole / 4);
  CHECK(read_back(half).width == 100);
  CHECK(read_back(half).height == 50);
  CHECK(to_png_within(image, 100).size() <= 100);
  const auto by_us = marked(half);
  CHECK(by_us.size() == half.size() + kMarkBytes);
  CHECK(is_marked(by_us));
  CHECK(!is_marked(half));
  CHECK(!is_marked(std::span(by_us).first(kMarkedBytes - 1)));
  CHECK(read_back(by_us).rgba == read_back(half).rgba);
}

TEST_CASE("a colour is laid over by its share and alpha") {
  Image image = blank_image(2, 1, kWhite);
  lay_over(image, 0, kBlack, 0.5);
  lay_over(image, 4, {0, 0, 0, 51}, 0.4);
  CHECK(image.rgba[0] == 128);
  CHECK(image.rgba[4] == 235);
  CHECK(image.rgba[3] == 255);
}

TEST_CASE("a mark is a ring around the point, also at the rim and outside of the picture") {
  Image image = blank_image(60, 60, {128, 128, 128, 255});
  draw_mark(image, {30, 30, 0});
  CHECK(image.rgba[image.at(30, 30)] == 128);
  CHECK(image.rgba[image.at(38, 30)] < 60);  // on the ring
  CHECK(image.rgba[image.at(30, 43)] < 60);  // on an arm
  CHECK(image.rgba[image.at(50, 50)] == 128);
  const Image before = image;
  draw_mark(image, {1e9, -1e9, 0});
  CHECK(image.rgba == before.rgba);
  draw_mark(image, {0, 60, 0});
  CHECK(image.rgba != before.rgba);
}

TEST_CASE("words are written in the letters that there are") {
  Image image = blank_image(140, 20, kWhite);
  write_word(image, 2, 3, "difference", kBlack);
  const std::size_t ink = count_of(image, kBlack);
  CHECK(ink > 400);
  CHECK(count_of(image, kWhite) + ink == 140 * 20);
  Image blank = blank_image(140, 20, kWhite);
  write_word(blank, 2, 3, "<Q>", kBlack);
  CHECK(count_of(blank, kBlack) == 0);
}
