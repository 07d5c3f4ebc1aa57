#include "server/sandbox/reading.h"

#include <string.h>
#include <sys/wait.h>

#include <algorithm>
#include <utility>

#include "api/formats/source.h"
#include "server/sandbox/channel.h"
#include "server/sandbox/protocol.h"

namespace meshgauge::server::sandbox {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds kTick{10};
constexpr milliseconds kEndTime{5000};  // for a process that was killed to be gone
constexpr std::size_t kPieceBytes = std::size_t{1} << 20;

std::string describe(std::optional<int> status) {
  if (!status) return "was lost";
  if (WIFSIGNALED(*status)) {
    const int signal = WTERMSIG(*status);
    const char* const name = ::sigdescr_np(signal);
    return "was ended by signal " + std::to_string(signal) + " (" + (name ? name : "unknown") + ")";
  }
  return "ended with exit code " + std::to_string(WEXITSTATUS(*status));
}

Error unreadable(const std::string& part, const std::string& why) {
  return api::about(part, ErrorCode::unreadable_mesh, "could not be read: " + why);
}

}  // namespace

Reading::Reading(Worker worker, const api::MeshInput& input, const api::ReadLimits& limits, bool seals)
    : worker_(std::move(worker)), input_(input), limits_(limits), seals_(seals), rest_(input.bytes) {}

// What fails here is seen in finish(): no answer comes.
void Reading::begin() {
  output_ = memory_file();
  const Descriptor copy = input_.file < 0 ? sealed_copy(input_.bytes) : Descriptor();
  const int file = input_.file < 0 ? copy.get() : input_.file;
  const Request request{input_.bytes.size(), limits_, input_.part, input_.filename, input_.media_type};
  send_message(worker_.channel(), encode(request), {file, output_.get()});
}

Outcome Reading::finish(Control& control) {
  while (!readable(worker_.channel(), rest_.empty() ? kTick : milliseconds(0))) {
    if (const Interruption why = control.check(); why != Interruption::none) return interrupted(why);
    digest_piece();
  }
  const auto message = receive_message(worker_.channel(), 0);
  if (!message) return crashed();
  Outcome outcome = judge(message->bytes);
  if (!outcome.mesh) return outcome;
  if (const Interruption why = digest(control); why != Interruption::none) return interrupted(why);
  outcome.mesh->sha256 = sha256_.hex();
  return outcome;
}

Outcome Reading::judge(const std::string& message) {
  const auto reply = decode_reply(message);
  if (!reply) return untrue("gave an answer that has no meaning");
  if (*reply) return accept(**reply);
  Error error = reply->error();
  if (!error.part.empty()) error.part = input_.part;
  const bool memory = error.message == api::out_of_memory(input_.part).message;
  return {memory ? End::out_of_memory : End::read, memory ? "ran out of memory" : "", std::move(error)};
}

Outcome Reading::accept(const Arrays& arrays) {
  if (!frozen()) return untrue("kept a hand on its output");
  const auto shared = SharedMesh::map(output_.get(), arrays.vertices, arrays.triangles);
  if (!shared) return untrue("gave an output of another size than it says");
  const auto valid = validate(shared->view(), {limits_.max_vertices, limits_.max_triangles}, input_.part);
  if (!valid) return untrue("gave an invalid mesh: " + valid.error().message);
  return {End::read, "", api::LoadedMesh{shared->view(), arrays.format, arrays.notes, "", shared}};
}

// Whatever the worker does from now on, its output stays what it is.
bool Reading::frozen() { return seals_ ? seal(output_.get()) : worker_.end(kEndTime).has_value(); }

Interruption Reading::digest(Control& control) {
  while (!rest_.empty()) {
    if (const Interruption why = control.check(); why != Interruption::none) return why;
    digest_piece();
  }
  return Interruption::none;
}

void Reading::digest_piece() {
  const auto piece = rest_.first(std::min(rest_.size(), kPieceBytes));
  sha256_.update(piece);
  rest_ = rest_.subspan(piece.size());
}

Outcome Reading::crashed() {
  return {End::crashed, describe(worker_.end(kEndTime)), unreadable(input_.part, "its reader ended abnormally")};
}

Outcome Reading::untrue(const std::string& how) const {
  return {End::untrue, how, unreadable(input_.part, "its reader gave no valid mesh")};
}

Outcome Reading::interrupted(Interruption why) const {
  const bool late = why == Interruption::timeout;
  return {late ? End::overdue : End::cancelled, late ? "was killed at the deadline" : "was killed: cancelled",
          api::not_in_time(why, "'" + input_.part + "' was read")};
}

}  // namespace meshgauge::server::sandbox
