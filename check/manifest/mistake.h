// Mistakes of a manifest with their places.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace meshgauge::check {

// 1-based; the column counts characters. Line 0: no place in particular.
struct Place {
  int line = 0;
  int column = 0;
};

struct Mistake {
  int line = 0;  // 0: the file as a whole
  int column = 0;
  std::string message;  // "unknown key 'max_distnace'; did you mean 'max_distance'?"
};

// A text of the manifest with its place.
struct Written {
  std::string text;
  Place place;
};

class Mistakes {
 public:
  // Maximum number of mistakes shown; a single misunderstanding may cause thousands.
  static constexpr std::size_t kMost = 100;

  void add(Place place, std::string message);
  bool empty() const { return all_.empty(); }

  // Returns the mistakes in the order of the file, each once: the first kMost, and how many more there are.
  std::vector<Mistake> sorted() &&;

 private:
  std::vector<Mistake> all_;
};

// Formats a mistake as editors expect it: "gates.yaml:7:5: unknown key 'x'".
std::string to_string(std::string_view file, const Mistake& mistake);

}  // namespace meshgauge::check
