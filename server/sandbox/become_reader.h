// Executes the small spawner program (server/sandbox/reader) in place of the running one.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace meshgauge::server::sandbox {

// Executes `program` from memory, with this process's arguments, environment and descriptors 0 to kControl
// (spawner.h); does not return on success. Otherwise returns why not, as a clause; empty if `program` is empty. Call
// it in the spawner's process while it has one thread.
std::string become_reader(std::span<const std::byte> program, char* const* arguments);

}  // namespace meshgauge::server::sandbox
