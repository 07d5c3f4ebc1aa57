#include "tests/api/formats/tinyobj_peer.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <limits>
#include <sstream>
#include <string>

#include <tiny_obj_loader.h>

#include "api/base/text.h"
#include "api/formats/polygons/polygons.h"

namespace meshgauge::api::test {
namespace {

struct Taken {
  Mesh mesh;
  Faces faces{mesh.triangles};
};

void take_vertex(void* user, tinyobj::real_t x, tinyobj::real_t y, tinyobj::real_t z, tinyobj::real_t /*w*/) {
  static_cast<Taken*>(user)->mesh.positions.emplace_back(x, y, z);
}

void take_face(void* user, tinyobj::index_t* corners, int count) {
  Taken& taken = *static_cast<Taken*>(user);
  const auto known = static_cast<std::int64_t>(taken.mesh.positions.size());
  taken.faces.begin();
  for (int k = 0; k < count; ++k) {
    const std::int64_t index = corners[k].vertex_index;
    taken.faces.add(static_cast<std::uint32_t>(index > 0 ? index - 1 : known + index));
  }
  taken.faces.end();
}

std::string_view next_word(std::string_view& line) {
  const char* const end = line.data() + line.size();
  const std::string_view word = word_at(skip_blanks(line.data(), end), end);
  line = {word.data() + word.size(), static_cast<std::size_t>(end - word.data()) - word.size()};
  return word;
}

// Returns true when tinyobjloader parses the number without overflow: it keeps mantissa and power of ten in doubles.
bool is_plain_number(std::string_view word) {
  constexpr std::size_t kMostCharacters = 25;
  constexpr int kMostExponent = 250;
  if (word.size() > kMostCharacters) return false;
  const std::size_t e = word.find_first_of("eE");
  if (e == std::string_view::npos) return true;
  const std::size_t digits = e + (e + 1 < word.size() && (word[e + 1] == '+' || word[e + 1] == '-') ? 2 : 1);
  int exponent = 0;
  const auto [next, fault] = std::from_chars(word.data() + digits, word.data() + word.size(), exponent);
  return fault == std::errc{} && exponent <= kMostExponent;
}

std::string_view excuse_of_line(std::string_view line) {
  const std::string_view statement = next_word(line);
  if (statement == "fo") return "a face of the format's first versions";
  if (statement == "f" && line.find('#') != std::string_view::npos) return "a comment behind a face";
  for (int k = 0; statement == "v" && k < 3; ++k) {
    if (!is_plain_number(next_word(line))) return "a number of many digits or of a large exponent";
  }
  return {};
}

}  // namespace

Mesh by_tinyobj(std::string_view text, const std::vector<Vec3>& positions) {
  std::istringstream stream{std::string(text)};
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = take_vertex;
  callbacks.index_cb = take_face;
  Taken taken;
  tinyobj::LoadObjWithCallback(stream, callbacks, &taken);
  ReadMesh split;
  split.mesh = {positions, taken.mesh.triangles};
  const auto in_range = [&](const Triangle& t) { return std::ranges::max(t) < positions.size(); };
  if (std::ranges::all_of(split.mesh.triangles, in_range)) {
    const ReadLimits limits;
    if (split_polygons(Source{{}, "peer", limits}, taken.faces.runs(), split))
      taken.mesh.triangles = split.mesh.triangles;
  }
  return std::move(taken.mesh);
}

std::string_view tinyobj_excuse(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) return "a byte order mark";
  if (text.find('\\') != std::string_view::npos) return "a line that goes on behind a backslash";
  if (text.find_first_of("\v\f") != std::string_view::npos) return "a vertical tab or a form feed";
  if (text.find_first_of(std::string_view("\0\x1A", 2)) != std::string_view::npos) return "a NUL or 0x1A byte";
  while (!text.empty()) {
    const std::size_t end = std::min(text.find_first_of("\r\n"), text.size());
    if (const auto excuse = excuse_of_line(text.substr(0, end)); !excuse.empty()) return excuse;
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return {};
}

std::uint64_t steps_apart(double a, double b) {
  const auto place = [](double x) {
    const auto bits = std::bit_cast<std::int64_t>(x);
    return bits < 0 ? std::numeric_limits<std::int64_t>::min() - bits : bits;
  };
  const auto [low, high] = std::minmax({place(a), place(b)});
  return static_cast<std::uint64_t>(high) - static_cast<std::uint64_t>(low);
}

}  // namespace meshgauge::api::test
