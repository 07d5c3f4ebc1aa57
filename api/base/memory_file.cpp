#include "api/base/memory_file.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <vector>

namespace meshgauge {
namespace {

// MFD_NOEXEC_SEAL and MFD_EXEC of Linux 6.3, which the C library may lack.
constexpr unsigned kNoExecSeal = 0x0008U;
constexpr unsigned kExec = 0x0010U;
constexpr std::size_t kPiece = std::size_t{1} << 20;  // read from a stream at a time
constexpr int kSizeSeals = F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL;

Descriptor memory_file(unsigned newer = kNoExecSeal) {
  constexpr unsigned kFlags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  const int file = ::memfd_create("meshgauge", kFlags | newer);
  if (file >= 0 || errno != EINVAL) return Descriptor(file);
  return Descriptor(::memfd_create("meshgauge", kFlags));
}

bool seal(const Descriptor& file, int seals) { return ::fcntl(file.get(), F_ADD_SEALS, seals) == 0; }

Descriptor copy(Descriptor file, std::span<const std::byte> bytes) {
  if (!file || !write_all(file.get(), bytes)) return Descriptor();
  seal(file, kSizeSeals | F_SEAL_WRITE);
  return file;
}

// Another process may have made the stream one that does not block. False: it cannot be waited for.
bool wait_for(int stream) {
  struct pollfd ready {
    stream, POLLIN, 0
  };
  return ::poll(&ready, 1, -1) >= 0 || errno == EINTR;
}

}  // namespace

bool seals_are_known() {
  const Descriptor file = memory_file();
  return file && seal(file, kSizeSeals | F_SEAL_WRITE);
}

Descriptor sealed_copy(std::span<const std::byte> bytes) { return copy(memory_file(), bytes); }

Descriptor executable_copy(std::span<const std::byte> bytes) { return copy(memory_file(kExec), bytes); }

SizedFile file_of_size(std::size_t bytes) {
  SizedFile sized{memory_file(), false};
  if (!sized.file || ::ftruncate(sized.file.get(), static_cast<off_t>(bytes)) != 0) return {};
  sized.fixed = seal(sized.file, kSizeSeals);
  return sized;
}

MemoryFile::~MemoryFile() {
  if (start_ != nullptr) ::munmap(const_cast<std::byte*>(start_), size_);
}

MemoryFile::End MemoryFile::read_all(int from, std::uint64_t most, MemoryFile& to) {
  const Descriptor file = memory_file();
  if (!file) return End::no_memory;
  std::vector<std::byte> piece(kPiece);
  std::uint64_t size = 0;
  for (;;) {
    const ssize_t n = ::read(from, piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0 && errno == EAGAIN && wait_for(from)) continue;
    if (n < 0) return End::not_readable;
    if (n == 0) break;
    const auto count = static_cast<std::size_t>(n);
    if (count > most - size) return End::too_large;
    if (!write_all(file.get(), {piece.data(), count})) return End::no_memory;
    size += count;
  }
  seal(file, kSizeSeals | F_SEAL_WRITE);  // where there are no seals, no other process has the file either
  if (size == 0) return to = MemoryFile(), End::whole;
  const auto length = static_cast<std::size_t>(size);
  if (length != size) return End::no_memory;  // more than 32 bits address
  void* const start = ::mmap(nullptr, length, PROT_READ, MAP_SHARED, file.get(), 0);
  if (start == MAP_FAILED) return End::no_memory;
  return to = MemoryFile(static_cast<const std::byte*>(start), length), End::whole;
}

}  // namespace meshgauge
