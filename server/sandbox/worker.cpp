#include "server/sandbox/worker.h"

#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <optional>
#include <vector>

#include "api/formats/source.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/confine.h"

namespace meshgauge::server::sandbox {
namespace {

constexpr int kNotConfined = 1;  // exit codes: seen in the server's log
constexpr int kNotAsked = 2;

bool confine(const Bounds& bounds, int parent) {
  if (!kSanitized && ::dup2(STDIN_FILENO, STDERR_FILENO) < 0) return false;  // /dev/null, to read from alone
  ::signal(SIGXFSZ, SIG_IGN);                                                // a write beyond RLIMIT_FSIZE just fails
  if (!limit_resources(bounds)) return false;
  if (::getppid() != parent) return false;  // it died before this process had asked to die with it
  return !bounds.filter || forbid_calls() == 0;
}

std::optional<std::span<const std::byte>> map_input(std::uint64_t size) {
  if (size == 0) return std::span<const std::byte>();
  void* const start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, kInput, 0);
  if (start == MAP_FAILED) return std::nullopt;
  return std::span(static_cast<const std::byte*>(start), size);
}

template <class T>
bool write_output(const std::vector<T>& array) {
  auto bytes = std::as_bytes(std::span(array));
  while (!bytes.empty()) {
    const ssize_t n = ::write(kOutput, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return true;
}

Reply write_mesh(const Result<api::ReadMesh>& read, const std::string& part) {
  if (!read) return read.error();
  const Mesh& mesh = read->mesh;
  if (!write_output(mesh.positions) || !write_output(mesh.triangles)) return api::out_of_memory(part);
  return Arrays{read->format, read->notes, mesh.positions.size(), mesh.triangles.size()};
}

}  // namespace

void run_worker(Read read, const Bounds& bounds, int parent) {
  if (!confine(bounds, parent)) ::_exit(kNotConfined);
  auto message = receive_message(kChannel, 2);
  if (!message) ::_exit(0);  // the server needs no more
  const auto request = decode_request(message->bytes);
  if (!request || message->files[0].get() != kInput || message->files[1].get() != kOutput) ::_exit(kNotAsked);
  const auto input = map_input(request->input_bytes);
  const auto mesh =
      input ? read(*input, {request->part, request->filename, request->media_type}, request->limits)
            : api::out_of_memory(request->part);
  const bool sent = send_message(kChannel, encode(write_mesh(mesh, request->part)));
  ::_exit(sent ? 0 : kNotAsked);  // nothing is freed or closed: the process is quicker at that
}

}  // namespace meshgauge::server::sandbox
