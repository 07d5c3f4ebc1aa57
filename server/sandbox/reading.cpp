#include "server/sandbox/reading.h"

#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

#include "api/formats/file/source.h"
#include "engine/mesh/large_array.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/worker.h"

namespace meshgauge::server::sandbox {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kReadEndTime{5000};  // time for a process to end after it has closed its channel
constexpr std::size_t kDigestBytes = std::size_t{1} << 20;

// The server's own copy of the arrays.
struct Copy {
  Copy(std::size_t vertices, std::size_t count) : positions(vertices), triangles(count) {}

  LargeArray<Vec3> positions;
  LargeArray<Triangle> triangles;
};
static_assert(sizeof(Vec3) == 3 * sizeof(double) && sizeof(Triangle) == 3 * sizeof(std::uint32_t));

std::string describe(std::optional<int> status) {
  if (!status) return "ended, or was never made, unseen";
  if (WIFSIGNALED(*status)) {
    const int signal = WTERMSIG(*status);
    const char* const name = ::sigdescr_np(signal);
    return "was ended by signal " + std::to_string(signal) + " (" + (name ? name : "unknown") + ")";
  }
  return "ended with exit code " + std::to_string(WEXITSTATUS(*status));
}

// SIGKILL comes from outside: the server does not kill a worker before its status is known.
bool was_lost(std::optional<int> status) {
  if (!status) return true;
  if (WIFSIGNALED(*status)) return WTERMSIG(*status) == SIGKILL;
  return WEXITSTATUS(*status) == kNotConfined || WEXITSTATUS(*status) == kNotAsked;
}

Error unreadable(const std::string& part, const std::string& why) {
  return api::about(part, ErrorCode::unreadable_mesh, "could not be read: " + why);
}

}  // namespace

ReadingOutcome interrupted(Interruption why, const std::string& part, const std::string& how) {
  const bool late = why == Interruption::timeout;
  return {late ? End::overdue : End::cancelled, how + (late ? " at the deadline" : ": cancelled"),
          api::not_in_time(why, "'" + part + "' was read")};
}

ReadingOutcome failed(const std::string& part, const std::string& how) {
  return {End::failed, how, Error{ErrorCode::internal, "the service could not read '" + part + "'", "", ""}};
}

ReadingOutcome no_memory(Error error) { return {End::cancelled, "", std::move(error)}; }

Reading::Reading(ReaderProcess worker, const api::MeshInput& input, const api::ReadLimits& limits, Memory* memory)
    : worker_(std::move(worker)), input_(input), limits_(limits), memory_(memory), rest_(input.bytes) {}

bool Reading::begin() {
  window_ = Window::open();
  const Descriptor copy = input_.file < 0 ? sealed_copy(input_.bytes) : Descriptor();
  const int file = input_.file < 0 ? copy.get() : input_.file;
  if (!window_ || file < 0) return false;
  const Request request{input_.bytes.size(), limits_, input_.part, input_.filename, input_.media_type};
  send_message(worker_.channel(), encode(request), {file, window_->file()});  // finish() detects a dead worker
  return true;
}

// Whatever a worker made of a file that the disk has damaged is not its sender's fault.
ReadingOutcome Reading::finish(Control& control) {
  ReadingOutcome outcome = wait_for_mesh(control);
  if (outcome.end == End::overdue || outcome.end == End::cancelled) return outcome;
  if (is_damaged(control)) {
    const std::string what =
        "the stored bytes of '" + input_.part + "' are damaged: their SHA-256 is another one; store the mesh again";
    return {End::failed, "was given a damaged file", Error{ErrorCode::internal, what, "", ""}};
  }
  if (!outcome.mesh) return outcome;
  return checked(std::move(outcome), control);
}

// Whatever bytes a worker sent, the engine gets a valid mesh.
ReadingOutcome Reading::checked(ReadingOutcome outcome, Control& control) const {
  Interruption why = Interruption::none;
  const auto valid = validate(outcome.mesh->mesh, {limits_.max_vertices, limits_.max_triangles}, input_.part, [&] {
    why = control.check();
    return why != Interruption::none;
  });
  if (why != Interruption::none) return killed(why);
  if (!valid) return untrue("gave an invalid mesh: " + valid.error().message);
  return outcome;
}

// Also false when `control` says to stop before that is known.
bool Reading::is_damaged(Control& control) {
  if (digest_rest(control) != Interruption::none) return false;
  return cut_off_ || (!input_.sha256.empty() && sha256() != input_.sha256);
}

const std::string& Reading::sha256() {
  if (digest_.empty()) digest_ = sha256_.hex();
  return digest_;
}

ReadingOutcome Reading::wait_for_mesh(Control& control) {
  if (const Interruption why = await_message(control); why != Interruption::none) return killed(why);
  const auto message = receive_message(worker_.channel(), 0);
  if (!message) return broken_off(control);
  auto reply = decode_reply(message->bytes);
  if (!reply) return untrue("gave an answer that has no meaning");
  if (!*reply) return refused(std::move(reply->error()));
  ReadingOutcome outcome = take_mesh(**reply, control);
  if (!outcome.mesh) return outcome;
  if (const Interruption why = digest_rest(control); why != Interruption::none) return killed(why);
  outcome.mesh->sha256 = sha256();
  return outcome;
}

// The worker may lie about the counts, within the limits of any mesh, send any bytes, change them until they are
// copied, and stop at any time.
ReadingOutcome Reading::take_mesh(const Arrays& arrays, Control& control) {
  if (arrays.vertices > limits_.max_vertices || arrays.triangles > limits_.max_triangles) {
    return untrue("gave more than the limits allow");
  }
  if (memory_) {
    if (auto ok = memory_->take_mesh(arrays.vertices, arrays.triangles); !ok) return no_memory(std::move(ok).error());
  }
  const auto copy = std::make_shared<Copy>(arrays.vertices, arrays.triangles);
  const auto positions = std::as_writable_bytes(std::span(copy->positions));
  const auto triangles = std::as_writable_bytes(std::span(copy->triangles));
  std::string table(arrays.group_bytes, '\0');
  const auto encoded = std::as_writable_bytes(std::span(table));
  const std::uint64_t count = count_pieces({positions.size(), triangles.size(), encoded.size()});
  Interruption why = Interruption::none;
  const auto take = [&](std::uint64_t number, std::span<std::byte> piece) {
    if (number >= kSlots) {
      why = await_message(control);
      if (why != Interruption::none || !receive_message(worker_.channel(), 0)) return false;
    }
    if (!window_->copy(number, piece)) return false;
    return number + kSlots >= count || send_message(worker_.channel(), kTurn);
  };
  const bool complete = for_each_piece({positions, triangles, encoded}, take);
  if (why != Interruption::none) return killed(why);
  if (!complete) return broken_off(control);
  auto groups = table.empty() ? api::Groups() : decode_groups(table, arrays.triangles);
  if (!groups) return untrue("gave groups that have no meaning");
  const MeshView mesh(copy->positions, copy->triangles);
  return {End::read, "", api::LoadedMesh{mesh, arrays.format, arrays.notes, "", copy, *std::move(groups)}};
}

// none: a message can be received, or the worker has ended.
Interruption Reading::await_message(Control& control) {
  for (;;) {
    if (const Interruption why = control.check(); why != Interruption::none) return why;
    if (readable(worker_.channel(), rest_.empty() ? kTick : milliseconds(0))) return Interruption::none;
    digest_piece();
  }
}

Interruption Reading::digest_rest(Control& control) {
  while (!rest_.empty()) {
    if (const Interruption why = control.check(); why != Interruption::none) return why;
    digest_piece();
  }
  return Interruption::none;
}

// A file is read, not looked at where it is mapped: a page that cannot be read would end this process.
void Reading::digest_piece() {
  if (rest_.empty()) return;
  const auto piece = rest_.first(std::min(rest_.size(), kDigestBytes));
  const std::size_t offset = input_.bytes.size() - rest_.size();
  rest_ = rest_.subspan(piece.size());
  if (input_.file < 0) return sha256_.update(piece);
  piece_.resize(piece.size());
  const ssize_t n = ::pread(input_.file, piece_.data(), piece_.size(), static_cast<off_t>(offset));
  if (n <= 0 && (n == 0 || errno != EINTR)) cut_off_ = true;
  const auto read = static_cast<std::size_t>(std::max<ssize_t>(n, 0));
  sha256_.update(std::span(piece_).first(read));
  rest_ = cut_off_ ? std::span<const std::byte>() : input_.bytes.subspan(offset + read);
}

// A reader's Error about the file, with the part checked, or the failure that it reports.
ReadingOutcome Reading::refused(Error error) const {
  if (!error.part.empty()) error.part = input_.part;
  if (error.code == ErrorCode::internal) {
    const std::string how = "failed: " + error.message;
    return {End::failed, how, std::move(error)};
  }
  const bool memory = error.message == api::out_of_memory(input_.part).message;
  return {memory ? End::out_of_memory : End::read, memory ? "ran out of memory" : "", std::move(error)};
}

// The channel is closed or carries nonsense. If the worker has ended, its status decides how the reading ended.
ReadingOutcome Reading::broken_off(Control& control) const {
  if (!closed(worker_.channel())) return untrue("broke off");
  Interruption why = Interruption::none;
  const auto status = worker_.status(kReadEndTime, [&] {
    why = control.check();
    return why != Interruption::none;
  });
  if (why != Interruption::none) return killed(why);
  if (!was_lost(status)) {
    return {End::crashed, describe(status), unreadable(input_.part, "its reader ended abnormally")};
  }
  return {End::lost, describe(status) + ", which its file did not do",
          Error{ErrorCode::internal, "the process that read '" + input_.part + "' was lost", "", ""}};
}

ReadingOutcome Reading::untrue(const std::string& how) const {
  return {End::untrue, how, unreadable(input_.part, "its reader gave no valid mesh")};
}

ReadingOutcome Reading::killed(Interruption why) const { return interrupted(why, input_.part, "was killed"); }

}  // namespace meshgauge::server::sandbox
