#include "server/base/heap.h"

#include <atomic>
#include <cstdlib>  // defines __GLIBC__
#include <new>
#include <thread>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace meshgauge::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kPause{10};
constexpr milliseconds kSameWait{200};  // a call that follows so soon is another try of the same allocation

std::atomic<milliseconds> most_wait{milliseconds(0)};
std::atomic<void (*)()> end_start{nullptr};
thread_local int may_fail = 0;
thread_local int never_fails = 0;
thread_local Clock::time_point wait_began;
thread_local Clock::time_point last_try;

bool has_waited_enough() {
  const auto now = Clock::now();
  if (now - last_try > kSameWait) wait_began = now;
  last_try = now;
  return now - wait_began > most_wait.load();
}

void wait_or_throw() {
  if (may_fail > 0) throw std::bad_alloc();
  if (has_waited_enough()) {
    if (void (*const end)() = end_start.load()) end();
    if (never_fails == 0) throw std::bad_alloc();
  }
  std::this_thread::sleep_for(kPause);
}

}  // namespace

void wait_for_memory(milliseconds most) {
  most_wait.store(most);
  std::set_new_handler(wait_or_throw);
}

void end_start_without_memory(void (*end)()) { end_start.store(end); }

NeverFails::NeverFails() { ++never_fails; }
NeverFails::~NeverFails() { --never_fails; }

MayFail::MayFail() { ++may_fail; }
MayFail::~MayFail() { --may_fail; }

void keep_heap_small([[maybe_unused]] unsigned threads_that_compute) {
#ifdef __GLIBC__
  constexpr int kForAllOthers = 2;  // threads that wait for clients and disks allocate little
  mallopt(M_ARENA_MAX, static_cast<int>(threads_that_compute) + kForAllOthers);
  // Larger blocks get a mapping each, which ends when they are freed. 128 KiB is glibc's initial value; without this
  // call it rises to the largest block that was ever freed, up to 32 MiB.
  mallopt(M_MMAP_THRESHOLD, 128 * 1024);
  mallopt(M_TRIM_THRESHOLD, 1024 * 1024);  // free bytes at an arena's end; the call above fixes it at 128 KiB
#endif
}

void release_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace meshgauge::server
