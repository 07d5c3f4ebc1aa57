// Times read_mesh on a binary STL of 100 MB and an OBJ of about 104 MB, both of 2 M triangles and made here, next
// to the plainest readers that fill the same Mesh from the same mapped file and check nothing. Prints the median
// seconds of each and their ratio.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iostream>
#include <string>
#include <vector>

#include "api/formats/format.h"
#include "api/formats/weld.h"

namespace {

using meshgauge::Mesh;
using meshgauge::Vec3;
namespace api = meshgauge::api;

constexpr std::uint32_t kSide = 1000;  // a height field of kSide x kSide squares, two triangles each

// Coordinates of 16 digits, as double precision exporters write them.
Vec3 grid_point(std::uint32_t i, std::uint32_t j) {
  const double x = 0.1234567891 * i + 1.0 / 3;
  const double y = 0.1234567891 * j + 1.0 / 7;
  return {x, y, std::sin(x) * std::cos(y)};
}

std::uint32_t grid_index(std::uint32_t i, std::uint32_t j) { return i * (kSide + 1) + j; }

Mesh grid() {
  Mesh mesh;
  for (std::uint32_t i = 0; i <= kSide; ++i) {
    for (std::uint32_t j = 0; j <= kSide; ++j) mesh.positions.push_back(grid_point(i, j));
  }
  for (std::uint32_t i = 0; i < kSide; ++i) {
    for (std::uint32_t j = 0; j < kSide; ++j) {
      mesh.triangles.push_back({grid_index(i, j), grid_index(i + 1, j), grid_index(i + 1, j + 1)});
      mesh.triangles.push_back({grid_index(i, j), grid_index(i + 1, j + 1), grid_index(i, j + 1)});
    }
  }
  return mesh;
}

void write_stl(const Mesh& mesh, const std::filesystem::path& path) {
  std::vector<char> bytes(84 + 50 * mesh.triangles.size());
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  std::memcpy(bytes.data() + 80, &count, sizeof count);
  char* facet = bytes.data() + 84;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3f p = mesh.positions[triangle[corner]].cast<float>();
      std::memcpy(facet + 12 * (corner + 1), p.data(), 12);
    }
    facet += 50;
  }
  std::FILE* file = std::fopen(path.c_str(), "wb");
  std::fwrite(bytes.data(), 1, bytes.size(), file);
  std::fclose(file);
}

void write_obj(const Mesh& mesh, const std::filesystem::path& path) {
  std::FILE* file = std::fopen(path.c_str(), "wb");
  for (const Vec3& p : mesh.positions) std::fprintf(file, "v %.16g %.16g %.16g\n", p.x(), p.y(), p.z());
  for (const auto& t : mesh.triangles) std::fprintf(file, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
  std::fclose(file);
}

// A file, mapped anew for every reading, so that each pays for its page faults.
class Mapped {
 public:
  explicit Mapped(const std::filesystem::path& path) : size_(std::filesystem::file_size(path)) {
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

using Reader = std::function<Mesh(std::span<const std::byte>)>;

double seconds(const Reader& reader, const std::filesystem::path& path, std::size_t triangles) {
  const auto start = std::chrono::steady_clock::now();
  const Mapped file(path);
  const Mesh mesh = reader(file.bytes());
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  if (mesh.triangles.size() != triangles) std::exit(1);
  return taken.count();
}

double median(std::vector<double> times) {
  std::ranges::sort(times);
  return times[times.size() / 2];
}

void compare(const std::string& name, const std::filesystem::path& path, const Reader& plain, std::size_t triangles,
             int repetitions) {
  std::vector<double> plain_times;
  std::vector<double> our_times;
  for (int i = 0; i <= repetitions; ++i) {
    const double theirs = seconds(plain, path, triangles);
    const double ours = seconds(by_read_mesh, path, triangles);
    if (i == 0) continue;  // brings the file into memory
    plain_times.push_back(theirs);
    our_times.push_back(ours);
  }
  std::printf("%s %.1f MB: read_mesh %.4f s, plain %.4f s, ratio %.2f (medians of %d)\n", name.c_str(),
              static_cast<double>(std::filesystem::file_size(path)) / 1e6, median(our_times), median(plain_times),
              median(our_times) / median(plain_times), repetitions);
}

void time_weld(const std::filesystem::path& path) {
  const Mapped file(path);
  Mesh mesh = by_read_mesh(file.bytes());
  const auto start = std::chrono::steady_clock::now();
  const std::size_t gone = api::weld(mesh);
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  std::printf("weld of the STL: %.4f s, %zu of %zu vertices went\n", taken.count(), gone, gone + mesh.positions.size());
}

}  // namespace

int main(int argc, char** argv) {
  const int repetitions = argc > 1 ? std::atoi(argv[1]) : 9;
  const auto folder = std::filesystem::temp_directory_path() / ("readers_bench_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const auto stl = folder / "grid.stl";
  const auto obj = folder / "grid.obj";
  const Mesh mesh = grid();
  write_stl(mesh, stl);
  write_obj(mesh, obj);
  compare("binary STL", stl, plain_stl, mesh.triangles.size(), repetitions);
  compare("OBJ", obj, plain_obj, mesh.triangles.size(), repetitions);
  time_weld(stl);
  std::filesystem::remove_all(folder);
}
