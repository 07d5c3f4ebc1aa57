// A spawner whose workers do what their file tells them to: what a reader might try that a file has taken over. A file
// that names no misdeed is read as a mesh.
//
//   sandbox_hostile             does all that is asked of it
//   sandbox_hostile forks N     cannot make more than N processes
//   sandbox_hostile hangs FILE  says nothing if there is such a file when it starts
//   sandbox_hostile ends FILE   ends at once if there is
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <new>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/formats/file/source.h"
#include "api/formats/read_part.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/confine.h"
#include "server/sandbox/spawner.h"
#include "server/sandbox/window.h"

namespace {

using namespace meshgauge;
using namespace meshgauge::server::sandbox;

constexpr std::size_t kMiB = std::size_t{1} << 20;

// What a misdeed says that was not stopped.
Error survived(const std::string& what) { return Error{ErrorCode::internal, what, "a", ""}; }

[[noreturn]] void for_ever() {
  for (volatile unsigned turn = 0;;) turn = turn + 1;
}

// --- ends that are none

Error loop() { for_ever(); }

volatile int* volatile g_nowhere = nullptr;

Error crash() {
  *g_nowhere = 1;
  return survived("nothing");
}

Error stop() { std::abort(); }

Error leave() { ::_exit(0); }

Error unconfined() { ::_exit(kNotConfined); }

// Only where calls are not forbidden.
Error close_and_live() {
  ::close(kChannel);
  for_ever();
}

// --- memory

// As a reader does that means no harm.
Error greedy() {
  std::vector<std::vector<char>> blocks;
  try {
    for (std::size_t taken = 0; taken < 10'240 * kMiB; taken += 64 * kMiB) blocks.emplace_back(64 * kMiB, 'x');
  } catch (const std::bad_alloc&) {
    blocks.clear();
    return api::out_of_memory("a");
  }
  return survived("10 GB");
}

// As one that does, whatever it is refused.
Error hoard() {
  std::size_t taken = 0;
  for (int i = 0; i < 640; ++i) {
    void* const block = ::mmap(nullptr, 16 * kMiB, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (block == MAP_FAILED) continue;
    std::memset(block, 1, 16 * kMiB);
    taken += 16;
  }
  return survived(std::to_string(taken));
}

// --- calls that are forbidden

template <class Call>
Error attempt(Call call) {
  call();
  return survived("the call came back");
}

Error open_file() {
  return attempt([] { return ::open("/etc/passwd", O_RDONLY | O_CLOEXEC); });
}
Error open_socket() {
  return attempt([] { return ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0); });
}
Error start_process() {
  return attempt([] { return ::fork(); });
}
Error run_program() {
  return attempt([] { return ::execl("/bin/true", "true", nullptr); });
}
Error kill_parent() {
  return attempt([] { return ::kill(::getppid(), SIGKILL); });
}
Error write_log() {
  return attempt([] { return ::write(STDERR_FILENO, "{}\n", 3); });
}
Error make_code() {
  return attempt(
      [] { return ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0); });
}
Error write_input() {
  return attempt([] { return ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, kInput, 0); });
}
Error write_file() {
  return attempt([] { return ::write(kWindow, "x", 1); });
}
Error make_code_of_window() {
  return attempt([] { return ::mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_SHARED, kWindow, 0); });
}
Error shorten_window() {
  return attempt([] { return ::ftruncate(kWindow, 1); });
}
Error outlive_parent() {
  return attempt([] { return ::prctl(PR_SET_PDEATHSIG, 0); });
}

// --- lies

const Mesh kTriangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};

std::byte* window() {
  static void* const start = ::mmap(nullptr, kWindowBytes, PROT_READ | PROT_WRITE, MAP_SHARED, kWindow, 0);
  if (start == MAP_FAILED) std::abort();
  return static_cast<std::byte*>(start);
}

void put(const Mesh& mesh) {
  std::uint64_t slot = 0;
  for (const auto bytes : {std::as_bytes(std::span(mesh.positions)), std::as_bytes(std::span(mesh.triangles))}) {
    if (!bytes.empty()) std::memcpy(window() + slot_of(slot++), bytes.data(), bytes.size());
  }
}

[[noreturn]] void say(const std::string& message) {
  send_message(kChannel, message);
  for_ever();  // the answer is out; that is no reason to go
}

std::string claim(std::uint64_t vertices, std::uint64_t triangles) {
  return encode(Reply(Arrays{api::Format::obj, {}, vertices, triangles}));
}

Error wrong_index() {
  Mesh mesh = kTriangle;
  mesh.triangles[0][2] = 3;
  put(mesh);
  say(claim(3, 1));
}

Error not_finite() {
  Mesh mesh = kTriangle;
  mesh.positions[1].y() = std::numeric_limits<double>::quiet_NaN();
  put(mesh);
  say(claim(3, 1));
}

Error no_triangles() {
  put(Mesh{kTriangle.positions, {}});
  say(claim(3, 0));
}

Error nothing() { say(claim(0, 0)); }

Error wrong_groups() {
  put(kTriangle);
  const std::string groups = encode(api::Groups{{{"a", {{0, 2}}}}});
  std::memcpy(window() + slot_of(2), groups.data(), groups.size());
  say(encode(Reply(Arrays{api::Format::obj, {}, 3, 1, groups.size()})));
}

Error far_too_long_groups() { say(encode(Reply(Arrays{api::Format::obj, {}, 3, 1, kMostEncodedGroups + 1}))); }

Error too_many() { say(claim(std::uint64_t{1} << 40, 1)); }

// More than there are addresses.
Error far_too_many() { say(claim(std::uint64_t{1} << 44, 1)); }

// 24 times this many overflows to 24 times 3.
Error overflow() {
  put(kTriangle);
  say(claim((std::uint64_t{1} << 61) + 3, 1));
}

// A million triangles, of which the first slots are all that ever comes.
Error too_few() {
  put(kTriangle);
  say(claim(3, 1'000'000));
}

Error too_few_and_gone() {
  put(kTriangle);
  send_message(kChannel, claim(3, 1'000'000));
  ::_exit(0);
}

Error format() {
  put(kTriangle);
  std::string message = claim(3, 1);
  message[8] = 77;  // behind the kind of the message
  say(message);
}

Error error_code() {
  std::string message = encode(Reply(survived("x")));
  message[8] = 77;
  say(message);
}

Error out_of_time() { say(encode(Reply(Error{ErrorCode::out_of_time, "the time was over", "", ""}))); }

Error bad_request() { say(encode(Reply(Error{ErrorCode::invalid_request, "an option is unknown", "options", ""}))); }

Error other_part() { say(encode(Reply(Error{ErrorCode::empty_mesh, "of another part", "b\r\nX: y", ""}))); }

Error rubbish() { say(std::string(5000, '\xFF')); }

Error long_message() {
  const std::string message(4 * kMaxMessageBytes, 'x');
  iovec text{const_cast<char*>(message.data()), message.size()};
  msghdr header{};
  header.msg_iov = &text;
  header.msg_iovlen = 1;
  ::sendmsg(kChannel, &header, 0);
  for_ever();
}

Error many_messages() {
  put(kTriangle);
  send_message(kChannel, claim(3, 1));
  for (;;) send_message(kChannel, claim(3, 1));
}

// Along with a true answer, the input and the window themselves, for the server to keep. The kernel may refuse, as long
// as others of this user send descriptors too.
Error descriptors() {
  put(kTriangle);
  while (!send_message(kChannel, claim(3, 1), {kInput, kWindow})) {
  }
  for_ever();
}

// --- changing what was handed over

// Bytes that are a coordinate and an index at times, and at times neither.
Error scribble() {
  put(kTriangle);
  send_message(kChannel, claim(3, 1));
  for (unsigned char value = 0;; ++value) {
    std::memset(window(), value, 72);
    std::memset(window() + kSlotBytes, value, 12);
  }
}

Error shorten_for_ever() {
  put(kTriangle);
  send_message(kChannel, claim(3, 1));
  for (;;) {
    [[maybe_unused]] const int shortened = ::ftruncate(kWindow, 0);
  }
}

struct Misdeed {
  std::string_view name;
  Error (*act)();
};

constexpr Misdeed kMisdeeds[] = {
    {"loop", loop},
    {"crash", crash},
    {"stop", stop},
    {"leave", leave},
    {"unconfined", unconfined},
    {"close and live", close_and_live},
    {"greedy", greedy},
    {"hoard", hoard},
    {"open file", open_file},
    {"open socket", open_socket},
    {"start process", start_process},
    {"run program", run_program},
    {"kill parent", kill_parent},
    {"write log", write_log},
    {"make code", make_code},
    {"make code of window", make_code_of_window},
    {"write input", write_input},
    {"write file", write_file},
    {"shorten window", shorten_window},
    {"outlive parent", outlive_parent},
    {"wrong index", wrong_index},
    {"not finite", not_finite},
    {"no triangles", no_triangles},
    {"nothing", nothing},
    {"wrong groups", wrong_groups},
    {"far too long groups", far_too_long_groups},
    {"too many", too_many},
    {"far too many", far_too_many},
    {"overflow", overflow},
    {"too few", too_few},
    {"too few and gone", too_few_and_gone},
    {"format", format},
    {"error code", error_code},
    {"out of time", out_of_time},
    {"bad request", bad_request},
    {"other part", other_part},
    {"rubbish", rubbish},
    {"long message", long_message},
    {"many messages", many_messages},
    {"descriptors", descriptors},
    {"scribble", scribble},
    {"shorten for ever", shorten_for_ever},
};

Result<api::ReadMesh> read(std::span<const std::byte> bytes, const api::ReadHints& hints,
                           const api::ReadLimits& limits) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  for (const Misdeed& misdeed : kMisdeeds) {
    if (misdeed.name == text) return misdeed.act();
  }
  return api::read_part(bytes, hints, limits);
}

int g_forks_left = std::numeric_limits<int>::max();

}  // namespace

// In place of the C library's.
extern "C" pid_t fork() noexcept {
  if (g_forks_left-- > 0) return reinterpret_cast<pid_t (*)()>(::dlsym(RTLD_NEXT, "fork"))();
  errno = EAGAIN;
  return -1;
}

int main(int argc, char** argv) {
  const std::string_view mode = argc > 2 ? argv[1] : "";
  if (mode == "forks") g_forks_left = std::atoi(argv[2]);
  if (mode == "ends" && ::access(argv[2], F_OK) == 0) return 1;
  while (mode == "hangs" && ::access(argv[2], F_OK) == 0) ::pause();
  if (mode == "clings" && ::fork() == 0) {  // a child that holds what the spawner holds
    for (::alarm(600);;) ::pause();         // at the longest
  }
  return run_spawner(read);
}
