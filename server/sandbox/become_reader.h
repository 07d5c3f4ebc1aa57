// The small program that is a spawner and nothing else (server/sandbox/reader), in place of the one that runs.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace meshgauge::server::sandbox {

// For the process that was started as a spawner, while it has one thread. Executes `program` from memory, with the
// arguments and the variables that this process has and with its descriptors 0 to kControl (spawner.h), and does not
// return then. Else gives a clause, why not; empty when `program` is.
std::string become_reader(std::span<const std::byte> program, char* const* arguments);

}  // namespace meshgauge::server::sandbox
