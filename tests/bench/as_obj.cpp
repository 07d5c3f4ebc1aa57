// Writes a mesh file of any format as OBJ, for rivals of ./dev bench that read nothing else.
//
//   bench_as_obj MESH OUT.obj
//
// The first line is "# diagonal D", the length of the bounding box's diagonal. Coordinates are exact. Exits with 1 and
// a message on stderr if MESH cannot be read or OUT.obj not be written.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <string>

#include "api/formats/format.h"

namespace {

using namespace meshgauge;

int fail(const std::string& message) {
  std::cerr << "bench_as_obj: " << message << '\n';
  return 1;
}

bool write(const Mesh& mesh, const char* path) {
  std::FILE* const out = std::fopen(path, "w");
  if (!out) return false;
  std::fprintf(out, "# diagonal %.17g\n", diagonal(bounding_box(mesh)));
  for (const Vec3& p : mesh.positions) std::fprintf(out, "v %.17g %.17g %.17g\n", p.x(), p.y(), p.z());
  for (const Triangle& t : mesh.triangles) std::fprintf(out, "f %u %u %u\n", t[0] + 1, t[1] + 1, t[2] + 1);
  const bool failed = std::ferror(out) != 0;
  return std::fclose(out) == 0 && !failed;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: bench_as_obj MESH OUT.obj");
  std::ifstream file(argv[1], std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file) return fail(std::string(argv[1]) + ": cannot be read");
  const auto read = api::read_mesh(std::as_bytes(std::span(bytes)), {"", argv[1], ""}, {});
  if (!read) return fail(std::string(argv[1]) + ": " + read.error().message);
  if (!write(read->mesh, argv[2])) return fail(std::string(argv[2]) + ": cannot be written");
  return 0;
}
