// The settings of memory that follow the machine.
#pragma once

#include <cstdint>
#include <string>

#include "server/settings/settings.h"

namespace meshgauge::server {

struct MachineMemory {
  std::uint64_t bytes = 0;           // that this process and its readers may use
  bool uploads_take_memory = false;  // temp_dir is on a tmpfs
};

MachineMemory machine_memory(const std::string& temp_dir);

// Fills in `max_memory_bytes` and `parser_memory_bytes` in place of 0, and lowers `max_cache_bytes`, `max_upload_bytes`
// and `max_heap_bytes` to what the machine can spare. Precondition: `workers` is not 0.
void plan_memory(const MachineMemory& machine, Settings& settings);

// What `max_memory_bytes` leave for meshes and readers when each thread that measures has its `max_heap_bytes`.
std::uint64_t memory_for_meshes(const Settings& settings);

// For the log: what the machine has, and how it is divided.
std::string memory_text(const Settings& settings);

}  // namespace meshgauge::server
