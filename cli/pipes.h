// Meshes from pipes on the command line: standard input ("-"), a FIFO, and /dev/fd/63 of a shell's <(command).
#pragma once

#include <memory>
#include <string>

#include "api/compare/mesh_file.h"
#include "engine/result.h"

namespace meshgauge::cli {

std::string name_of_mesh(const std::string& path);  // in messages and results: "-" is "standard input"

// Refuses the same pipe for both meshes, since a pipe can be read once, and "-" where standard input is a terminal.
// Reads nothing.
Result<Done> check_pipes(const std::string& a, const std::string& b);

// The paths of two meshes as api::MeshFile::open() takes them.
struct TwoMeshes {
  std::string a;
  std::string b;
  std::shared_ptr<const api::Pipes> pipes;  // null: neither is a pipe
};

// Reads to their ends those of two meshes that are pipes, `a` first. Blocks until their writers have closed them. An
// Error: as check_pipes(), or a pipe cannot be read or sends more than fits into the memory.
Result<TwoMeshes> with_pipes(const std::string& a, const std::string& b);

}  // namespace meshgauge::cli
