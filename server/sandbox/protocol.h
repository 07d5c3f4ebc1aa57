// Messages between the processes of the sandbox. Both sides are copies of one program, so numbers travel in the
// machine's own form. A worker may have been taken over by its file, so decode_reply() trusts nothing: each number
// has a range, each text an end, and no byte may be left over.
//
//   server -> spawner Bounds: try to confine a process to them
//   spawner -> server Trial: the result
//   server -> spawner Bounds, with the ends of two channels: fork a worker with these limits
//   server -> worker Request, with the input and the window (window.h)
//   worker -> server Reply; on success the arrays follow through the window
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/format.h"
#include "engine/result.h"

namespace meshgauge::server::sandbox {

// Limits of one worker, enforced by the kernel.
struct Bounds {
  std::uint64_t memory_bytes = 0;  // private writable memory
  std::uint64_t input_bytes = 0;   // size of the largest file, which the worker maps
  std::uint64_t cpu_seconds = 0;
  bool filter = true;  // whether the filter of system calls is required (confine.h)
};

// What a process could not confine: a clause each; empty: all is well.
struct Trial {
  std::string limits;  // not empty: no worker can be made
  std::string filter;  // not empty: workers run with less protection
  std::string
      small;  // why the spawner is not the small program (become_reader.h), which makes readings slower; empty: it is
};

struct Request {
  std::uint64_t input_bytes = 0;
  api::ReadLimits limits;
  std::string part;
  std::string filename;
  std::string media_type;
};

// Sizes of the arrays that come through the window: positions, triangles, then the encoded groups.
struct Arrays {
  api::Format format = api::Format::obj;
  api::ReadNotes notes;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
  std::uint64_t group_bytes = 0;  // 0: no groups; at most kMostEncodedGroups
};

using Reply = Result<Arrays>;

inline constexpr std::uint64_t kMostEncodedGroups =
    api::kMostBytesOfGroups + (3 * api::kMostGroupRanges + 2) * sizeof(std::uint64_t);

std::string encode(const Bounds& bounds);
std::string encode(const Trial& trial);      // each clause is cut like a text
std::string encode(const Request& request);  // a hint is cut to its last 1,024 bytes
std::string encode(const Reply& reply);      // a text is cut to its first 4,096 bytes

std::string encode(const api::Groups& groups);

std::optional<Bounds> decode_bounds(std::string_view message);
std::optional<Trial> decode_trial(std::string_view message);
std::optional<Request> decode_request(std::string_view message);
// Decodes and checks a reply. nullopt: it is invalid. An Error has one of a reader's codes, never out_of_time or
// invalid_request, which only the server decides.
std::optional<Reply> decode_reply(std::string_view message);
// Decodes and checks the groups of a mesh with this many triangles. nullopt: they are invalid.
std::optional<api::Groups> decode_groups(std::string_view bytes, std::uint64_t triangles);

}  // namespace meshgauge::server::sandbox
