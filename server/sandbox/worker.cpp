#include "server/sandbox/worker.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <string>

#include "api/formats/file/source.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/confine.h"
#include "server/sandbox/window.h"

namespace meshgauge::server::sandbox {
namespace {

bool confine(const Bounds& bounds, const Rules& rules, int parent) {
  if (!kSanitized && ::dup2(STDIN_FILENO, STDERR_FILENO) < 0) return false;  // /dev/null, opened for reading
  if (!limit_resources(bounds)) return false;
  if (::getppid() != parent) return false;  // the parent died before PR_SET_PDEATHSIG was set
  return !bounds.filter || forbid_calls(rules) == 0;
}

std::optional<std::span<const std::byte>> map_input(std::uint64_t size) {
  if (size == 0) return std::span<const std::byte>();
  void* const start = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, kInput, 0);
  if (start == MAP_FAILED) return std::nullopt;
  return std::span(static_cast<const std::byte*>(start), size);
}

std::span<const std::byte> bytes_of(const auto& array) { return std::as_bytes(std::span(array)); }

// Sends the arrays; see window.h.
bool hand_over(const api::ReadMesh& read) {
  const auto positions = bytes_of(read.mesh.positions);
  const auto triangles = bytes_of(read.mesh.triangles);
  void* const start = ::mmap(nullptr, kWindowBytes, PROT_READ | PROT_WRITE, MAP_SHARED, kWindow, 0);
  if (start == MAP_FAILED) return false;
  const std::string table = read.groups == api::Groups() ? "" : encode(read.groups);
  const auto groups = bytes_of(table);
  const std::string reply = encode(
      Reply(Arrays{read.format, read.notes, read.mesh.positions.size(), read.mesh.triangles.size(), groups.size()}));
  const std::uint64_t with_reply = std::min(kSlots, count_pieces({positions.size(), triangles.size(), groups.size()}));
  const auto give = [&](std::uint64_t number, std::span<const std::byte> piece) {
    if (number >= kSlots && !receive_message(kChannel, 0)) return false;
    std::memcpy(static_cast<std::byte*>(start) + slot_of(number), piece.data(), piece.size());
    if (number + 1 < with_reply) return true;
    return send_message(kChannel, number < kSlots ? reply : kTurn);
  };
  return for_each_piece({positions, triangles, groups}, give);
}

}  // namespace

void run_worker(Read read, const Bounds& bounds, const Rules& rules, int parent) {
  if (!confine(bounds, rules, parent)) ::_exit(kNotConfined);
  auto message = receive_message(kChannel, 2);
  if (!message) ::_exit(0);  // the server needs no more
  const auto request = decode_request(message->bytes);
  if (!request || message->files[0].get() != kInput || message->files[1].get() != kWindow) ::_exit(kNotAsked);
  const auto input = map_input(request->input_bytes);
  const auto mesh = input ? read(*input, {request->part, request->filename, request->media_type}, request->limits)
                          : api::out_of_memory(request->part);
  const bool done = mesh ? hand_over(*mesh) : send_message(kChannel, encode(Reply(mesh.error())));
  ::_exit(done ? 0 : kNotTaken);  // nothing is freed or closed: the kernel does it faster
}

}  // namespace meshgauge::server::sandbox
