// Loaded before the C library (LD_PRELOAD): makes single calls of one process fail, and counts them.
//
// MESHGAUGE_FAULTS=<file>. The file is mapped: what to fail (Orders), and a table of the places from which the process
// has called (Site). A place is the address after the call; it is the same in each life of a program that is started
// without address space randomisation. faults.py gives the orders.
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <new>

namespace {

enum Kind : std::int32_t { kRead, kWrite, kSync, kMap, kRename, kAllocation, kThread, kConnect, kKinds };

struct Orders {
  std::atomic<std::int32_t> process;  // 0: none; -1: each that maps this file
  std::atomic<std::int32_t> kind;     // that fails; -1: none
  std::atomic<std::int32_t> error;    // errno of what fails
  std::atomic<std::int32_t> lasting;  // 0: one call fails; 1: all from that one on
  std::atomic<std::int64_t> after;    // calls to let pass before
  std::atomic<std::uint64_t> place;   // that fails; 0: any
  std::atomic<std::int64_t> failed;   // calls since the orders were given
  std::atomic<std::int64_t> calls[kKinds];
};

struct Site {
  std::atomic<std::uint64_t> place;
  std::atomic<std::int32_t> kind;
  std::atomic<std::int32_t> failed;
  std::atomic<std::int64_t> calls;
};

constexpr std::size_t kSites = 1 << 14;
constexpr std::int32_t kEveryProcess = -1;

struct Table {
  Orders orders;
  Site sites[kSites];
};

Table* table = nullptr;
std::int32_t self = 0;

// Where the process dies, for the report.
void tell_death(int signal) {
  void* frames[64];
  ::backtrace_symbols_fd(frames, ::backtrace(frames, 64), STDERR_FILENO);
  ::signal(signal, SIG_DFL);
}

__attribute__((constructor)) void begin() {
  const char* const name = std::getenv("MESHGAUGE_FAULTS");
  if (!name) return;
  const int file = ::open(name, O_RDWR | O_CLOEXEC);
  void* const start = ::mmap(nullptr, sizeof(Table), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  ::close(file);
  self = ::getpid();
  void* first[1];
  ::backtrace(first, 1);  // loads what it needs
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS}) ::signal(signal, tell_death);
  if (start != MAP_FAILED) table = static_cast<Table*>(start);
}

Site* site_of(Kind kind, std::uint64_t place) {
  for (std::size_t i = 0, at = place * 0x9e3779b97f4a7c15u >> 50; i < kSites; ++i, at = (at + 1) % kSites) {
    Site& site = table->sites[at];
    std::uint64_t there = site.place.load(std::memory_order_relaxed);
    if (there == 0 && site.place.compare_exchange_strong(there, place)) {
      site.kind = kind;
      return &site;
    }
    if (there == place) return &site;
  }
  return nullptr;
}

bool fails(Kind kind, void* caller) {
  if (!table) return false;
  const std::int32_t whose = table->orders.process.load(std::memory_order_relaxed);
  if (whose != self && whose != kEveryProcess) return false;
  Orders& orders = table->orders;
  ++orders.calls[kind];
  const auto place = reinterpret_cast<std::uint64_t>(caller);
  Site* const site = site_of(kind, place);
  if (site) ++site->calls;
  if (orders.kind.load() != kind) return false;
  const std::uint64_t only = orders.place.load();
  if (only != 0 && only != place) return false;
  const std::int64_t left = orders.after.fetch_sub(1);
  if (left > 0 || (left < 0 && orders.lasting.load() == 0)) return false;
  ++orders.failed;
  if (site) ++site->failed;
  errno = orders.error.load();
  return true;
}

template <class Function>
Function next(Function, const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

#define FAILING(kind, type, name, failed, parameters, ...)               \
  extern "C" type name parameters {                                      \
    static const auto real = next(&name, #name);                         \
    if (fails(kind, __builtin_return_address(0))) return (type)(failed); \
    return real(__VA_ARGS__);                                            \
  }

FAILING(kRead, ssize_t, read, -1, (int file, void* bytes, size_t size), file, bytes, size)
FAILING(kRead, ssize_t, pread, -1, (int file, void* bytes, size_t size, off_t at), file, bytes, size, at)
FAILING(kRead, ssize_t, pread64, -1, (int file, void* bytes, size_t size, off64_t at), file, bytes, size, at)
FAILING(kRead, ssize_t, recv, -1, (int file, void* bytes, size_t size, int flags), file, bytes, size, flags)
FAILING(kWrite, ssize_t, write, -1, (int file, const void* bytes, size_t size), file, bytes, size)
FAILING(kWrite, ssize_t, pwrite, -1, (int file, const void* bytes, size_t size, off_t at), file, bytes, size, at)
FAILING(kWrite, ssize_t, pwrite64, -1, (int file, const void* bytes, size_t size, off64_t at), file, bytes, size, at)
FAILING(kWrite, ssize_t, send, -1, (int file, const void* bytes, size_t size, int flags), file, bytes, size, flags)
FAILING(kSync, int, fsync, -1, (int file), file)
FAILING(kSync, int, fdatasync, -1, (int file), file)
FAILING(kMap, void*, mmap, MAP_FAILED,
        (void* at, size_t size, int protection, int flags, int file, off_t from) noexcept, at, size, protection, flags,
        file, from)
FAILING(kMap, void*, mmap64, MAP_FAILED,
        (void* at, size_t size, int protection, int flags, int file, off64_t from) noexcept, at, size, protection,
        flags, file, from)
FAILING(kRename, int, rename, -1, (const char* from, const char* to) noexcept, from, to)
FAILING(kConnect, int, connect, -1, (int file, const sockaddr* address, socklen_t size), file, address, size)

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                              void* argument) noexcept {
  static const auto real = next(&pthread_create, "pthread_create");
  return fails(kThread, __builtin_return_address(0)) ? EAGAIN : real(thread, attributes, run, argument);
}

// The C library's own names: dlsym() allocates.
extern "C" void* __libc_malloc(size_t size);
extern "C" void* __libc_calloc(size_t number, size_t size);
extern "C" void* __libc_realloc(void* block, size_t size);
extern "C" void* __libc_memalign(size_t alignment, size_t size);

extern "C" void* malloc(size_t size) noexcept {
  return fails(kAllocation, __builtin_return_address(0)) ? nullptr : __libc_malloc(size);
}
extern "C" void* calloc(size_t number, size_t size) noexcept {
  return fails(kAllocation, __builtin_return_address(0)) ? nullptr : __libc_calloc(number, size);
}
extern "C" void* realloc(void* block, size_t size) noexcept {
  return fails(kAllocation, __builtin_return_address(0)) ? nullptr : __libc_realloc(block, size);
}

namespace {

// As the standard says: the handler makes room, or throws.
void* allocate(std::size_t size, std::size_t alignment, void* caller) {
  while (true) {
    void* block = nullptr;
    if (!fails(kAllocation, caller)) block = alignment == 0 ? __libc_malloc(size) : __libc_memalign(alignment, size);
    if (block) return block;
    const std::new_handler handler = std::get_new_handler();
    if (!handler) throw std::bad_alloc();
    handler();
  }
}

}  // namespace

void* operator new(std::size_t size) { return allocate(size, 0, __builtin_return_address(0)); }
void* operator new[](std::size_t size) { return allocate(size, 0, __builtin_return_address(0)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment), __builtin_return_address(0));
}
