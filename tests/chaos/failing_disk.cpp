// Loaded before the C library (LD_PRELOAD): makes one folder behave as one on a disk that fails, while a file says so.
//
// MESHGAUGE_FAILING_DISK=<folder>:<file>. The file's three 32-bit numbers are mapped: the process concerned (-1: each
// that has this variable), the errno that everything which writes to the folder fails with (0: none), and the seconds
// by which its clock is wrong. A real file system that is in use by a writer cannot be made read-only from outside;
// after an I/O error the kernel does so, and this is what it looks like.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <string_view>

namespace {

struct Orders {
  std::int32_t process;
  std::int32_t error;
  std::int32_t clock_is_wrong_by;
};

const volatile Orders* orders = nullptr;
std::string_view folder;  // with a slash; empty until the orders are read: constructors come in no order
pid_t self = 0;

__attribute__((constructor)) void read_orders() {
  const char* text = std::getenv("MESHGAUGE_FAILING_DISK");
  if (!text) return;
  const std::string both = text;
  const std::size_t colon = both.find(':');
  static const std::string with_slash = both.substr(0, colon) + "/";
  folder = with_slash;
  self = ::getpid();
  using Open = int (*)(const char*, int, ...);
  const int file = reinterpret_cast<Open>(::dlsym(RTLD_NEXT, "open"))(both.c_str() + colon + 1, O_RDONLY | O_CLOEXEC);
  void* start = ::mmap(nullptr, sizeof(Orders), PROT_READ, MAP_SHARED, file, 0);
  ::close(file);
  if (start != MAP_FAILED) orders = static_cast<const volatile Orders*>(start);
}

constexpr std::int32_t kEveryProcess = -1;

bool is_meant() { return orders && (orders->process == kEveryProcess || orders->process == self); }

int ordered() { return is_meant() ? orders->error : 0; }

bool concerns(const char* path) { return std::string_view(path).starts_with(folder); }

bool concerns(int file) {
  char path[4096];
  const ssize_t length = ::readlink(("/proc/self/fd/" + std::to_string(file)).c_str(), path, sizeof path);
  return length > 0 && std::string_view(path, static_cast<std::size_t>(length)).starts_with(folder);
}

template <class Target>
bool fails(Target target) {
  const int error = ordered();
  if (error == 0 || !concerns(target)) return false;
  errno = error;
  return true;
}

bool writes(int flags) { return (flags & O_ACCMODE) != O_RDONLY || (flags & (O_CREAT | O_TRUNC)) != 0; }

// A file that is there may be opened by a database, whose own flags say what for; new ones may not be made.
bool fails_to_open(const char* path, int flags) { return writes(flags) && (flags & O_CREAT) != 0 && fails(path); }

template <class Function>
Function next(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

#define FAILING(type, name, parameters, target, ...)                  \
  extern "C" type name parameters {                                   \
    static const auto real = next(&name, #name);                      \
    return fails(target) ? static_cast<type>(-1) : real(__VA_ARGS__); \
  }

FAILING(ssize_t, write, (int file, const void* bytes, size_t size), file, file, bytes, size)
FAILING(ssize_t, pwrite, (int file, const void* bytes, size_t size, off_t at), file, file, bytes, size, at)
FAILING(ssize_t, pwrite64, (int file, const void* bytes, size_t size, off64_t at), file, file, bytes, size, at)
FAILING(int, ftruncate, (int file, off_t size) noexcept, file, file, size)
FAILING(int, ftruncate64, (int file, off64_t size) noexcept, file, file, size)
FAILING(int, fsync, (int file), file, file)
FAILING(int, fdatasync, (int file), file, file)
FAILING(int, rename, (const char* from, const char* to) noexcept, to, from, to)
FAILING(int, unlink, (const char* path) noexcept, path, path)
FAILING(int, mkdir, (const char* path, mode_t mode) noexcept, path, path, mode)
FAILING(int, mkostemp, (char* path, int flags), path, path, flags)
FAILING(int, utimensat, (int at, const char* path, const timespec* times, int flags) noexcept, path, at, path, times,
        flags)

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real = next(&clock_gettime, "clock_gettime");
  const int failed = real(clock, time);
  if (clock == CLOCK_REALTIME && is_meant()) time->tv_sec += orders->clock_is_wrong_by;
  return failed;
}

#define FAILING_OPEN(name)                                                               \
  extern "C" int name(const char* path, int flags, ...) {                                \
    static const auto real = next(&name, #name);                                         \
    std::va_list rest;                                                                   \
    va_start(rest, flags);                                                               \
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(rest, mode_t) : 0; \
    va_end(rest);                                                                        \
    return fails_to_open(path, flags) ? -1 : real(path, flags, mode);                    \
  }

FAILING_OPEN(open)
FAILING_OPEN(open64)
