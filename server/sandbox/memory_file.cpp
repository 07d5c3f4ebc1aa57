#include "server/sandbox/memory_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

namespace meshgauge::server::sandbox {
namespace {

// MFD_NOEXEC_SEAL and MFD_EXEC of Linux 6.3, which the C library may lack.
constexpr unsigned kNoExecSeal = 0x0008U;
constexpr unsigned kExec = 0x0010U;
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

}  // namespace meshgauge::server::sandbox
