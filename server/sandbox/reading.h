// One file in one worker, as the server sees it: hand it over, wait, check what comes back.
#pragma once

#include <string>

#include "api/digest.h"
#include "api/load.h"
#include "server/sandbox/nursery.h"
#include "server/sandbox/protocol.h"
#include "server/sandbox/shared_file.h"

namespace meshgauge::server::sandbox {

// How a reading ended.
enum class End {
  read,           // with a mesh, or with what a reader has to say against the file
  out_of_memory,  // the reader ran into the limit of its memory and said so
  crashed,        // the worker was gone before it answered
  untrue,         // what it answered is not what a reader gives
  overdue,        // killed at the deadline
  cancelled,      // killed because nobody wants the mesh any more
};

struct Outcome {
  End end = End::read;
  std::string how;  // a clause for the log: "the reader of 'a' ..."; empty when there is nothing to say
  Result<api::LoadedMesh> mesh;
};

class Reading {
 public:
  // Borrows `input` and `limits`. `seals`: whether this kernel knows them (shared_file.h); if not, the worker is ended
  // before its output is looked at.
  Reading(Worker worker, const api::MeshInput& input, const api::ReadLimits& limits, bool seals);

  void begin();  // hands the file over; does not wait

  // Waits for the answer and takes the digest of the file meanwhile. Asks `control` every 10 ms at least; whatever it
  // gives, the worker is gone or about to go.
  Outcome finish(Control& control);

 private:
  Outcome judge(const std::string& message);
  Outcome accept(const Arrays& arrays);
  bool frozen();
  Interruption digest(Control& control);
  void digest_piece();
  Outcome crashed();
  Outcome untrue(const std::string& how) const;
  Outcome interrupted(Interruption why) const;

  Worker worker_;
  const api::MeshInput& input_;
  const api::ReadLimits& limits_;
  const bool seals_;
  Descriptor output_;
  api::Sha256 sha256_;
  std::span<const std::byte> rest_;  // of the input, still to be digested
};

}  // namespace meshgauge::server::sandbox
