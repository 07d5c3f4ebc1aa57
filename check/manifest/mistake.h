// What is wrong in a manifest, and where: for people, who want all of it at once.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::check {

// 1-based, a column in characters; line 0: nowhere in particular.
struct Place {
  int line = 0;
  int column = 0;
};

struct Mistake {
  int line = 0;  // 0: of the file as a whole
  int column = 0;
  std::string message;  // "unknown key 'max_distnace'; did you mean 'max_distance'?"
};

// A text of the manifest, and where it stands.
struct Written {
  std::string text;
  Place place;
};

class Mistakes {
 public:
  // Beyond this many one hides the other: what one misunderstanding has caused a thousand times is said a hundred
  // times.
  static constexpr std::size_t kMost = 100;

  void add(Place place, std::string message);
  bool empty() const { return all_.empty(); }

  // In the order of the file, each once; of more than kMost the first, and how many there are besides.
  std::vector<Mistake> sorted() &&;

 private:
  std::vector<Mistake> all_;
};

// "gates.yaml:7:5: unknown key 'x'": as editors and people find it.
std::string to_string(std::string_view file, const Mistake& mistake);

}  // namespace meshgauge::check
