#include "cli/pipes.h"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <new>

#include "api/base/descriptor.h"
#include "api/base/machine.h"
#include "api/base/memory_file.h"
#include "api/base/refused.h"

namespace meshgauge::cli {
namespace {

constexpr const char* kStandardInput = "-";

// Where a mesh comes from. A path that leads to standard input, such as /dev/stdin, is read by that descriptor: a
// socket has no other way.
struct Source {
  bool found = false;  // false: there is no such file
  bool is_pipe = false;
  bool is_stdin = false;
  struct stat status {};
};

bool same(const struct stat& a, const struct stat& b) { return a.st_dev == b.st_dev && a.st_ino == b.st_ino; }

Source source_of(const std::string& path) {
  struct stat input {};
  const bool has_input = ::fstat(STDIN_FILENO, &input) == 0;
  if (path == kStandardInput) return {has_input, true, true, input};
  Source source;
  source.found = ::stat(path.c_str(), &source.status) == 0;
  source.is_pipe = source.found && (S_ISFIFO(source.status.st_mode) || S_ISSOCK(source.status.st_mode));
  source.is_stdin = source.is_pipe && has_input && same(source.status, input);
  return source;
}

// What a pipe may send: half of the memory, or what a limit of the process leaves. The rest is for the mesh.
std::uint64_t most_bytes() {
  std::uint64_t most = api::memory_bytes() / 2;
  struct rlimit limit {};
  if (::getrlimit(RLIMIT_AS, &limit) == 0) most = std::min<std::uint64_t>(most, limit.rlim_cur);
  return most;
}

Error bad_mesh_file(const std::string& path, const std::string& why) {
  return refused("'" + name_of_mesh(path) + "' " + why);
}

Error not_read(const std::string& path) {
  return bad_mesh_file(path, std::string("cannot be read: ") + std::strerror(errno));
}

// Opens the pipe, which blocks until it has a writer. No descriptor, with errno: it cannot be opened.
Descriptor opened(const std::string& path, const Source& source) {
  if (source.is_stdin) return Descriptor(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0));
  int fd = -1;
  do fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  while (fd < 0 && errno == EINTR);
  return Descriptor(fd);
}

Result<MemoryFile> read(const std::string& path, const Source& source) try {
  const Descriptor pipe = opened(path, source);
  if (!pipe) return not_read(path);
  const std::uint64_t most = most_bytes();
  MemoryFile file;
  switch (MemoryFile::read_all(pipe.get(), most, file)) {
    case MemoryFile::End::whole:
      return file;
    case MemoryFile::End::not_readable:
      return not_read(path);
    case MemoryFile::End::too_large:
      return Error{ErrorCode::too_large,
                   "'" + name_of_mesh(path) + "' is larger than the memory: a pipe may send at most " +
                       std::to_string(most) + " bytes here",
                   "", ""};
    case MemoryFile::End::no_memory:
      break;
  }
  return Error{ErrorCode::too_large, "'" + name_of_mesh(path) + "' is larger than the memory", "", ""};
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::too_large, "'" + name_of_mesh(path) + "' is larger than the memory", "", ""};
}

}  // namespace

std::string name_of_mesh(const std::string& path) { return path == kStandardInput ? "standard input" : path; }

Result<Done> check_pipes(const std::string& a, const std::string& b) {
  const Source of_a = source_of(a), of_b = source_of(b);
  if (!of_a.is_pipe && !of_b.is_pipe) return Done{};
  if (a == b || (of_a.found && of_b.found && same(of_a.status, of_b.status))) {
    const bool is_stdin = of_a.is_stdin || of_b.is_stdin;
    return refused((is_stdin ? "standard input" : "the pipe '" + a + "'") +
                   " can be one mesh only: name a file or another pipe for the other");
  }
  if (name_of_mesh(a) == name_of_mesh(b))  // the name of a file may be "standard input"
    return bad_mesh_file(a, "is a file and a pipe at once: write './' before the file's name");
  for (const std::string& path : {a, b}) {
    if (path == kStandardInput && ::isatty(STDIN_FILENO) != 0)
      return refused(
          "standard input is a terminal: send a mesh into it, as in 'meshgauge ... - < part.stl', or name a "
          "file in place of '-'");
  }
  return Done{};
}

Result<TwoMeshes> with_pipes(const std::string& a, const std::string& b) {
  if (auto ok = check_pipes(a, b); !ok) return ok.error();
  TwoMeshes meshes{name_of_mesh(a), name_of_mesh(b), nullptr};
  const auto pipes = std::make_shared<api::Pipes>();
  for (const std::string& path : {a, b}) {
    const Source source = source_of(path);
    if (!source.is_pipe) continue;
    auto file = read(path, source);
    if (!file) return file.error();
    pipes->emplace(name_of_mesh(path), std::move(*file));
  }
  if (!pipes->empty()) meshes.pipes = pipes;
  return meshes;
}

}  // namespace meshgauge::cli
