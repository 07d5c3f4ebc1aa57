#include "server/sandbox/window.h"

#include <sys/mman.h>
#include <unistd.h>

#include <cstring>

namespace meshgauge::server::sandbox {

std::optional<Window> Window::open() {
  SizedFile sized = file_of_size(kWindowBytes);
  if (!sized.file) return std::nullopt;
  if (!sized.fixed) return Window(std::move(sized), nullptr);
  const void* const start = ::mmap(nullptr, kWindowBytes, PROT_READ, MAP_SHARED, sized.file.get(), 0);
  if (start == MAP_FAILED) return std::nullopt;
  return Window(std::move(sized), static_cast<const std::byte*>(start));
}

Window::Window(Window&& other) noexcept
    : sized_(std::move(other.sized_)), start_(std::exchange(other.start_, nullptr)) {}

Window& Window::operator=(Window&& other) noexcept {
  std::swap(sized_, other.sized_);
  std::swap(start_, other.start_);
  return *this;
}

Window::~Window() {
  if (start_ != nullptr) ::munmap(const_cast<std::byte*>(start_), kWindowBytes);
}

bool Window::copy(std::uint64_t piece, std::span<std::byte> to) const {
  if (start_ != nullptr) {
    std::memcpy(to.data(), start_ + slot_of(piece), to.size());
    return true;
  }
  const ssize_t read = ::pread(file(), to.data(), to.size(), static_cast<off_t>(slot_of(piece)));
  return read == static_cast<ssize_t>(to.size());
}

}  // namespace meshgauge::server::sandbox
