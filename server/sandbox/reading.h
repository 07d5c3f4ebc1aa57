// One file in one worker, as the server sees it: hand it over, wait, take what comes back, and only then look at it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "api/digest.h"
#include "api/load.h"
#include "server/sandbox/protocol.h"
#include "server/sandbox/spawner_client.h"
#include "server/sandbox/window.h"

namespace meshgauge::server::sandbox {

// How a reading ended.
enum class End {
  read,           // with a mesh, or with what a reader has to say against the file
  out_of_memory,  // the reader ran into the limit of its memory and said so
  crashed,        // the worker ended before it had given all: by what it did
  untrue,         // what it gave is not what a reader gives
  overdue,        // at the deadline
  cancelled,      // nobody wants the mesh any more
  lost,           // the worker ended, or never began, through no doing of its file: another may read it
  failed,         // the service, or the reader by its own account, could not do its part
};
inline constexpr std::array<std::string_view, 8> kEndNames{"read",    "out_of_memory", "crashed", "untrue",
                                                           "overdue", "cancelled",     "lost",    "failed"};

struct ReadingOutcome {
  End end = End::read;
  std::string how;  // a clause for the log: "the reader of 'a' ..."; empty when there is nothing to say
  Result<api::LoadedMesh> mesh;
};

// What comes of a reading that is not to go on; `how` it stood: "was killed".
ReadingOutcome interrupted(Interruption why, const std::string& part, const std::string& how);
ReadingOutcome failed(const std::string& part, const std::string& how);

class Reading {
 public:
  // Borrows `input` and `limits`.
  Reading(ReaderProcess worker, const api::MeshInput& input, const api::ReadLimits& limits);

  bool begin();  // hands the file over, does not wait; false: memory or descriptors ran out

  // Precondition: begin() gave true. Waits for the mesh and takes the digest of the file meanwhile. Asks `control`
  // every 10 ms at least; with the reading the worker goes. Throws std::bad_alloc, and std::length_error for as much.
  ReadingOutcome finish(Control& control);

 private:
  ReadingOutcome take_mesh(const Arrays& arrays, Control& control);
  Interruption await_message(Control& control);
  Interruption digest_rest(Control& control);
  void digest_piece();
  ReadingOutcome refused(Error error) const;
  ReadingOutcome broken_off(Control& control) const;
  ReadingOutcome untrue(const std::string& how) const;
  ReadingOutcome killed(Interruption why) const;

  ReaderProcess worker_;
  const api::MeshInput& input_;
  const api::ReadLimits& limits_;
  std::optional<Window> window_;
  api::Sha256 sha256_;
  std::span<const std::byte> rest_;  // of the input, still to be digested
};

}  // namespace meshgauge::server::sandbox
