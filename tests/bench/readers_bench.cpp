// Times read_mesh on a generated file of about 100 MB of each format, and for STL and OBJ also the simplest readers
// that fill the same Mesh and check nothing. Each reading is a separate process, so that each pays for its pages and
// has its own peak of memory. Prints a table of the fastest times.
//
//   readers_bench [REPETITIONS]
//   readers_bench read|plain FILE     one reading: its seconds and its peak of resident KiB
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "api/formats/format.h"
#include "api/formats/read_part.h"
#include "mesh_files.h"

namespace {

using meshgauge::Mesh;
using meshgauge::Vec3;
namespace api = meshgauge::api;
namespace bench = meshgauge::bench;

constexpr std::uint32_t kSide = 1000;
constexpr std::uint32_t kShortSide = 400;  // of ASCII STL, which takes eight times as many bytes a triangle

class Mapped {
 public:
  explicit Mapped(const bench::Path& path) : size_(std::filesystem::file_size(path)) {
    const int file = open(path.c_str(), O_RDONLY);
    data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file, 0);
    close(file);
    if (data_ == MAP_FAILED) std::exit(1);
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  ~Mapped() { munmap(data_, size_); }
  std::span<const std::byte> bytes() const { return {static_cast<const std::byte*>(data_), size_}; }

 private:
  std::size_t size_;
  void* data_;
};

Mesh plain_stl(std::span<const std::byte> bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof count);
  Mesh mesh;
  mesh.positions.reserve(3 * std::size_t{count});
  mesh.triangles.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    float c[9];
    std::memcpy(c, bytes.data() + 96 + 50 * std::size_t{i}, sizeof c);
    for (int k = 0; k < 9; k += 3) mesh.positions.emplace_back(double{c[k]}, double{c[k + 1]}, double{c[k + 2]});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  return mesh;
}

Mesh plain_obj(std::span<const std::byte> bytes) {
  const char* p = reinterpret_cast<const char*>(bytes.data());
  const char* const end = p + bytes.size();
  Mesh mesh;
  mesh.positions.reserve((kSide + 1) * (kSide + 1));
  mesh.triangles.reserve(std::size_t{2} * kSide * kSide);
  while (p < end) {
    if (*p == 'v') {
      Vec3 v;
      for (int k = 0; k < 3; ++k) p = std::from_chars(p + (k == 0 ? 2 : 1), end, v[k]).ptr;
      mesh.positions.push_back(v);
    } else {
      meshgauge::Triangle t{};
      for (std::size_t k = 0; k < 3; ++k) {
        p = std::from_chars(p + (k == 0 ? 2 : 1), end, t[k]).ptr;
        --t[k];
      }
      mesh.triangles.push_back(t);
    }
    ++p;
  }
  return mesh;
}

Mesh by_read_mesh(std::span<const std::byte> bytes) {
  auto result = api::read_mesh(bytes, {"a", "", ""}, {});
  if (!result) {
    std::cerr << result.error().message << '\n';
    std::exit(1);
  }
  return std::move(result->mesh);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

long peak_resident_kib() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) return std::atol(line.c_str() + 6);
  }
  return 0;
}

int read_once(const std::string& reader, const bench::Path& path) {
  const auto start = std::chrono::steady_clock::now();
  const Mapped file(path);
  const bool plain = reader == "plain";
  const Mesh mesh = !plain                       ? by_read_mesh(file.bytes())
                    : path.extension() == ".stl" ? plain_stl(file.bytes())
                                                 : plain_obj(file.bytes());
  std::printf("%.6f %ld %zu\n", seconds_since(start), peak_resident_kib(), mesh.triangles.size());
  return 0;
}

struct Reading {
  double seconds = 0;
  long kib = 0;
  std::size_t triangles = 0;
};

Reading in_a_process(const std::string& reader, const bench::Path& path) {
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  std::FILE* out = popen(("'" + self + "' " + reader + " '" + path.string() + "'").c_str(), "r");
  Reading reading;
  const int fields = std::fscanf(out, "%lf %ld %zu", &reading.seconds, &reading.kib, &reading.triangles);
  if (pclose(out) != 0 || fields != 3) std::exit(1);
  return reading;
}

// The smallest time counts: other load on the machine can only slow a reading down.
Reading fastest_of(const std::string& reader, const bench::Path& path, int repetitions) {
  std::vector<Reading> readings;
  in_a_process(reader, path);  // brings the file into memory
  for (int i = 0; i < repetitions; ++i) readings.push_back(in_a_process(reader, path));
  return *std::ranges::min_element(readings, {}, &Reading::seconds);
}

void print_row(const char* name, const bench::Path& path, bool has_plain, int repetitions) {
  const double megabytes = static_cast<double>(std::filesystem::file_size(path)) / 1e6;
  const Reading ours = fastest_of("read", path, repetitions);
  std::printf("| %s | %.1f | %.2f | %.3f | %.0f | %.0f |", name, megabytes, static_cast<double>(ours.triangles) / 1e6,
              ours.seconds, megabytes / ours.seconds, static_cast<double>(ours.kib) * 1024 / 1e6);
  if (has_plain) {
    const Reading plain = fastest_of("plain", path, repetitions);
    std::printf(" %.3f s, %.2f times |\n", plain.seconds, ours.seconds / plain.seconds);
  } else {
    std::printf(" |\n");
  }
  std::fflush(stdout);
}

void time_merging(const bench::Path& path) {
  const Mapped file(path);
  const auto start = std::chrono::steady_clock::now();
  const auto read = api::read_part(file.bytes(), {"a", "", ""}, {});
  if (!read) std::exit(1);
  std::printf("\nthe binary STL with its vertices merged: %.3f s, %zu of %zu vertices went\n", seconds_since(start),
              read->notes.welded_vertices, read->notes.welded_vertices + read->mesh.positions.size());
}

struct Row {
  const char* name;
  const char* file;
  void (*write)(const Mesh&, const bench::Path&);
  std::uint32_t side = kSide;
  bool has_plain = false;
};
constexpr Row kRows[] = {{"STL, binary", "binary.stl", bench::write_stl, kSide, true},
                         {"STL, ASCII", "ascii.stl", bench::write_ascii_stl, kShortSide},
                         {"OBJ", "grid.obj", bench::write_obj, kSide, true},
                         {"PLY, binary, double", "binary.ply", bench::write_binary_ply},
                         {"PLY, ASCII", "ascii.ply", bench::write_ascii_ply},
                         {"OFF", "grid.off", bench::write_off},
                         {"GLB", "grid.glb", bench::write_glb},
                         {"glTF, data URI", "grid.gltf", bench::write_gltf},
                         {"3MF", "grid.3mf", bench::write_3mf}};

void run(const bench::Path& folder, int repetitions) {
  std::printf(
      "| format | MB | million triangles | s | MB/s | peak MB | plain reader |\n|---|--:|--:|--:|--:|--:|---|\n");
  for (const Row& row : kRows) {
    row.write(bench::grid(row.side), folder / row.file);
    print_row(row.name, folder / row.file, row.has_plain, repetitions);
  }
  for (const auto& [name, file] : {std::pair("STL, binary, gzip", "binary.stl"), std::pair("OBJ, gzip", "grid.obj")}) {
    const bench::Path compressed = folder / (std::string(file) + ".gz");
    bench::write_gzip(folder / file, compressed);
    print_row(name, compressed, false, repetitions);
  }
  time_merging(folder / "binary.stl");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3) return read_once(argv[1], argv[2]);
  const auto folder = std::filesystem::temp_directory_path() / ("readers_bench_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  run(folder, argc > 1 ? std::max(1, std::atoi(argv[1])) : 9);
  std::filesystem::remove_all(folder);
}
