// Compares our OBJ reader with tinyobjloader: build/tests/bench/obj_peer_bench [VERTICES]
//
// Writes an OBJ of random coordinates, each with 17 digits, reads it by both, and prints how many coordinates differ
// from those of strtod and the time of each reader, the smallest of five. docs/decisions/packages.md quotes it.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <tiny_obj_loader.h>

#include "api/formats/format.h"

namespace {

using Coordinates = std::vector<double>;
using Clock = std::chrono::steady_clock;

struct Sample {
  std::string text;
  Coordinates exact;  // strtod's of the same digits
};

Sample sample_of(int vertices) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(-100, 100);
  Sample sample;
  char word[40];
  for (int i = 0; i < vertices; ++i) {
    sample.text += "v";
    for (int k = 0; k < 3; ++k) {
      std::snprintf(word, sizeof word, " %.17g", coordinate(random));
      sample.text += word;
      sample.exact.push_back(std::strtod(word, nullptr));
    }
    sample.text += "\n";
  }
  for (int i = 1; i + 2 <= vertices; ++i) {
    sample.text += "f " + std::to_string(i) + " " + std::to_string(i + 1) + " " + std::to_string(i + 2) + "\n";
  }
  return sample;
}

Coordinates by_us(const std::string& text) {
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(text.data()), text.size());
  const auto read = meshgauge::api::read_mesh(bytes, {"a", "a.obj", ""}, meshgauge::api::ReadLimits{});
  Coordinates out;
  if (!read) return out;
  for (const auto& p : read->mesh.positions) out.insert(out.end(), {p[0], p[1], p[2]});
  return out;
}

// Reads with its fastest interface.
Coordinates by_tinyobj(const std::string& text) {
  std::istringstream stream(text);
  tinyobj::callback_t callbacks;
  callbacks.vertex_cb = [](void* out, double x, double y, double z, double /*w*/) {
    static_cast<Coordinates*>(out)->insert(static_cast<Coordinates*>(out)->end(), {x, y, z});
  };
  callbacks.index_cb = [](void* /*out*/, tinyobj::index_t* /*corners*/, int /*count*/) {};
  Coordinates out;
  tinyobj::LoadObjWithCallback(stream, callbacks, &out);
  return out;
}

template <class Read>
void measure(const char* name, const Sample& sample, Read read) {
  double least = std::numeric_limits<double>::infinity();
  Coordinates coordinates;
  for (int i = 0; i < 5; ++i) {
    const auto start = Clock::now();
    coordinates = read(sample.text);
    least = std::min(least, std::chrono::duration<double>(Clock::now() - start).count());
  }
  std::size_t wrong = sample.exact.size();
  if (coordinates.size() == sample.exact.size()) {
    wrong = 0;
    for (std::size_t i = 0; i < coordinates.size(); ++i) wrong += coordinates[i] != sample.exact[i] ? 1U : 0U;
  }
  std::printf("%-14s %6.2f %% of %zu coordinates differ from strtod, %.3f s\n", name,
              100.0 * static_cast<double>(wrong) / static_cast<double>(sample.exact.size()), sample.exact.size(),
              least);
}

}  // namespace

int main(int argc, char** argv) {
  const Sample sample = sample_of(argc > 1 ? std::atoi(argv[1]) : 500'000);
  measure("meshgauge", sample, by_us);
  measure("tinyobjloader", sample, by_tinyobj);
}
