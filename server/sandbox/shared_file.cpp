#include "server/sandbox/shared_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace meshgauge::server::sandbox {
namespace {

constexpr unsigned kNoExecSeal = 0x0008U;  // MFD_NOEXEC_SEAL of Linux 6.3, which the C library may not know yet
constexpr int kSeals = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(std::uint32_t));

bool write_all(int file, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

}  // namespace

Descriptor memory_file() {
  constexpr unsigned kFlags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  const int file = ::memfd_create("meshgauge", kFlags | kNoExecSeal);
  if (file >= 0 || errno != EINVAL) return Descriptor(file);
  return Descriptor(::memfd_create("meshgauge", kFlags));
}

bool seal(int file) { return ::fcntl(file, F_ADD_SEALS, kSeals) == 0; }

bool seals_are_known() {
  const Descriptor file = memory_file();
  return file && seal(file.get());
}

Descriptor sealed_copy(std::span<const std::byte> bytes) {
  Descriptor file = memory_file();
  if (!file || !write_all(file.get(), bytes)) return Descriptor();
  seal(file.get());
  return file;
}

std::shared_ptr<const SharedMesh> SharedMesh::map(int file, std::uint64_t vertices, std::uint64_t triangles) {
  struct stat status {};
  if (::fstat(file, &status) != 0 || status.st_size <= 0) return nullptr;
  const auto size = static_cast<std::uint64_t>(status.st_size);
  // Each by itself first: their sum might overflow.
  if (vertices > size / sizeof(Vec3) || triangles > size / sizeof(Triangle)) return nullptr;
  if (vertices * sizeof(Vec3) + triangles * sizeof(Triangle) != size) return nullptr;
  // Private, though nobody writes: before Linux 6.7 a sealed file cannot be mapped shared, not even to be read.
  void* const start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file, 0);
  if (start == MAP_FAILED) return nullptr;
  return std::shared_ptr<const SharedMesh>(new SharedMesh(start, vertices, triangles));
}

SharedMesh::SharedMesh(void* start, std::size_t vertices, std::size_t triangles)
    : start_(start),
      view_({static_cast<const Vec3*>(start), vertices},
            {reinterpret_cast<const Triangle*>(static_cast<const Vec3*>(start) + vertices), triangles}) {}

SharedMesh::~SharedMesh() {
  ::munmap(start_, view_.positions.size_bytes() + view_.triangles.size_bytes());
}

}  // namespace meshgauge::server::sandbox
