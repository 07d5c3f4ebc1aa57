// One file in one worker, from the server's side: hands the file over, waits, copies the arrays, then checks them.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/digest.h"
#include "api/compare/load.h"
#include "engine/result.h"
#include "server/sandbox/protocol.h"
#include "server/sandbox/spawner_client.h"
#include "server/sandbox/window.h"

namespace meshgauge::server::sandbox {

// What a reading asks for before it takes memory. An Error ends the reading, and is its result. For the thread that
// reads.
class Memory {
 public:
  virtual ~Memory() = default;

  // Before a wait until another file has been read. An Error: do not wait.
  virtual Result<Done> wait_for_turn() { return Done{}; }
  // For the process that reads, in place of all that was taken since end_reader(): an earlier process's attempt at the
  // same file has failed. Returns the limit of its memory, at most `bytes`.
  virtual Result<std::uint64_t> take_reader(std::uint64_t bytes) = 0;
  virtual void end_reader() = 0;  // the process has ended; its mesh stays
  // For the mesh, in this process, before its arrays come.
  virtual Result<Done> take_mesh(std::uint64_t vertices, std::uint64_t triangles) = 0;
};

// How a reading ended.
enum class End {
  read,           // a mesh, or a reader's Error about the file
  out_of_memory,  // the reader reported that its memory limit was reached
  crashed,        // the worker ended early, through its own doing
  untrue,         // the reply is not one that a reader gives
  overdue,        // at the deadline
  cancelled,      // the caller cancelled
  lost,           // the worker ended or never began through no doing of the file; another may read it
  failed,         // the service, or the reader by its own report, failed
};
inline constexpr std::array<std::string_view, 8> kEndNames{"read",    "out_of_memory", "crashed", "untrue",
                                                           "overdue", "cancelled",     "lost",    "failed"};

struct ReadingOutcome {
  End end = End::read;
  std::string how;  // a clause for the log: "the reader of 'a' ..."; empty when there is nothing to say
  Result<api::LoadedMesh> mesh;
};

// Returns the outcome of a reading that was stopped. `how`: what happened to it, such as "was killed".
ReadingOutcome interrupted(Interruption why, const std::string& part, const std::string& how);
ReadingOutcome failed(const std::string& part, const std::string& how);
ReadingOutcome no_memory(Error error);  // of Memory

class Reading {
 public:
  // Borrows `input`, `limits` and `memory`, which is asked before the arrays come; null: it is not.
  Reading(ReaderProcess worker, const api::MeshInput& input, const api::ReadLimits& limits, Memory* memory = nullptr);

  bool begin();  // hands the file over without blocking; false: memory or descriptors ran out

  // Waits for the mesh, and computes the file's digest meanwhile. Precondition: begin() returned true. Checks
  // `control` at least every 10 ms. The worker ends with this object. Throws std::bad_alloc, or std::length_error
  // when the arrays are too large.
  ReadingOutcome finish(Control& control);

 private:
  ReadingOutcome wait_for_mesh(Control& control);
  bool is_damaged(Control& control);
  const std::string& sha256();  // precondition: the rest is empty
  ReadingOutcome take_mesh(const Arrays& arrays, Control& control);
  ReadingOutcome checked(ReadingOutcome outcome, Control& control) const;  // precondition: it has a mesh
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
  Memory* const memory_;
  std::optional<Window> window_;
  api::Sha256 sha256_;
  std::string digest_;               // empty: not finished
  std::span<const std::byte> rest_;  // input still to be digested
  std::vector<std::byte> piece_;     // of it
  bool cut_off_ = false;             // the file has fewer bytes than the input, or cannot be read
};

}  // namespace meshgauge::server::sandbox
