// Lets the library of the wheel run with a glibc that is older than the one it is linked with: 2.31 and later. Only in
// builds with MESHGAUGE_STATIC.
//
// Functions that a newer glibc moved from libpthread and libdl to libc, or gave another version, are taken in the
// version that every glibc has: the linker's --wrap sends all calls of NAME to __wrap_NAME. A function that an older
// glibc has not is defined here.
#include <fcntl.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#if defined(__x86_64__)
#define FIRST_VERSION "GLIBC_2.2.5"
#define JUMP "jmp"
#define BY_TABLE "@PLT"
#elif defined(__aarch64__)
#define FIRST_VERSION "GLIBC_2.17"
#define JUMP "b"
#define BY_TABLE ""
#endif

#define IN_VERSION(name, version)                                                                     \
  __asm__(".symver first_" #name ", " #name "@" version "\n.pushsection .text\n.globl __wrap_" #name  \
          "\n.hidden __wrap_" #name "\n.type __wrap_" #name ", %function\n__wrap_" #name ":\n\t" JUMP \
          " first_" #name BY_TABLE "\n.popsection")

IN_VERSION(dladdr, FIRST_VERSION);
IN_VERSION(dlclose, FIRST_VERSION);
IN_VERSION(dlerror, FIRST_VERSION);
IN_VERSION(dlopen, FIRST_VERSION);
IN_VERSION(dlsym, FIRST_VERSION);
IN_VERSION(hypot, FIRST_VERSION);
IN_VERSION(pthread_cond_clockwait, "GLIBC_2.30");
IN_VERSION(pthread_create, FIRST_VERSION);
IN_VERSION(pthread_detach, FIRST_VERSION);
IN_VERSION(pthread_getspecific, FIRST_VERSION);
IN_VERSION(pthread_join, FIRST_VERSION);
IN_VERSION(pthread_key_create, FIRST_VERSION);
IN_VERSION(pthread_key_delete, FIRST_VERSION);
IN_VERSION(pthread_once, FIRST_VERSION);
IN_VERSION(pthread_rwlock_destroy, FIRST_VERSION);
IN_VERSION(pthread_rwlock_init, FIRST_VERSION);
IN_VERSION(pthread_rwlock_rdlock, FIRST_VERSION);
IN_VERSION(pthread_rwlock_unlock, FIRST_VERSION);
IN_VERSION(pthread_rwlock_wrlock, FIRST_VERSION);
IN_VERSION(pthread_setspecific, FIRST_VERSION);

extern "C" {

// Before 2.33, stat() and its family were inline functions. The kernel's struct is the C library's on 64-bit machines.
int fstatat(int folder, const char* path, struct stat* status, int flags) {
  return static_cast<int>(syscall(SYS_newfstatat, folder, path, status, flags));
}
int fstat(int file, struct stat* status) { return fstatat(file, "", status, AT_EMPTY_PATH); }
int stat(const char* path, struct stat* status) { return fstatat(AT_FDCWD, path, status, 0); }
int lstat(const char* path, struct stat* status) { return fstatat(AT_FDCWD, path, status, AT_SYMLINK_NOFOLLOW); }
int fstat64(int file, struct stat64* status) { return fstat(file, reinterpret_cast<struct stat*>(status)); }
int stat64(const char* path, struct stat64* status) { return stat(path, reinterpret_cast<struct stat*>(status)); }

// Before 2.36 glibc had no arc4random.
void arc4random_buf(void* buffer, std::size_t size) {
  for (auto* at = static_cast<unsigned char*>(buffer); size > 0;) {
    const ssize_t count = getrandom(at, size, 0);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) std::abort();  // the system has no random numbers, and arc4random_buf has no way to say so
    at += count;
    size -= static_cast<std::size_t>(count);
  }
}
std::uint32_t arc4random() {
  std::uint32_t random = 0;
  arc4random_buf(&random, sizeof random);
  return random;
}

// Debian's libpng.a is compiled for programs, and expects stderr in the same object as itself.
extern FILE* __real_stderr;
__attribute__((visibility("hidden"))) FILE* __wrap_stderr = nullptr;
__attribute__((constructor(101))) static void set_stderr() { __wrap_stderr = __real_stderr; }

// Before 2.32 glibc did not say whether a process has but one thread: no is always right.
char __libc_single_threaded = 0;
}
