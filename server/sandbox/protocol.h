// What the processes of the sandbox say to each other. Two copies of one program talk, so numbers go in the machine's
// own form; yet a worker may have been taken over by its file, so decode_reply() believes nothing: every number has a
// range, every text an end, and no byte may be left.
//
//   server  -> spawner  Bounds: try to confine a process to them
//   spawner -> server   Trial: how that went
//   server  -> spawner  Bounds, with the ends of two channels: fork a worker with these limits
//   server  -> worker   Request, with the input and the window (window.h)
//   worker  -> server   Reply; on success the arrays come through the window
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/formats/format.h"
#include "engine/result.h"

namespace meshgauge::server::sandbox {

// What one worker may use. The kernel holds it to that.
struct Bounds {
  std::uint64_t memory_bytes = 0;  // private memory that it can write to
  std::uint64_t input_bytes = 0;   // the largest file it is given, which it maps
  std::uint64_t cpu_seconds = 0;
  bool filter = true;  // whether the filter of system calls must be in force (confine.h)
};

// What a process that tried to confine itself could not have; a clause each, empty when all is well.
struct Trial {
  std::string limits;  // without these no worker can be had
  std::string filter;  // without this there are workers with less protection
  std::string small;   // why the spawner is not the small program (become_reader.h): without it all takes longer
};

struct Request {
  std::uint64_t input_bytes = 0;
  api::ReadLimits limits;
  std::string part;
  std::string filename;
  std::string media_type;
};

// What comes through the window: the positions, then the triangles.
struct Arrays {
  api::Format format = api::Format::obj;
  api::ReadNotes notes;
  std::uint64_t vertices = 0;
  std::uint64_t triangles = 0;
};

using Reply = Result<Arrays>;

std::string encode(const Bounds& bounds);
std::string encode(const Trial& trial);      // a clause is cut as a text is
std::string encode(const Request& request);  // a hint is cut to its last 1,024 bytes
std::string encode(const Reply& reply);      // a text is cut to its first 4,096 bytes

std::optional<Bounds> decode_bounds(std::string_view message);
std::optional<Trial> decode_trial(std::string_view message);
std::optional<Request> decode_request(std::string_view message);
// An Error has one of the codes that readers give: not out_of_time or invalid_request, which are the server's to say.
std::optional<Reply> decode_reply(std::string_view message);

}  // namespace meshgauge::server::sandbox
