#include "server/sandbox/become_reader.h"

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "api/base/memory_file.h"

namespace meshgauge::server::sandbox {

std::string become_reader(std::span<const std::byte> program, char* const* arguments) {
  if (program.empty()) return "";
  const Descriptor file = executable_copy(program);
  // By its descriptor, which is closed by that: /proc may not be there.
  if (file) ::syscall(SYS_execveat, file.get(), "", arguments, environ, AT_EMPTY_PATH);
  return std::string("no program in memory can be executed: ") + std::strerror(errno);
}

}  // namespace meshgauge::server::sandbox
