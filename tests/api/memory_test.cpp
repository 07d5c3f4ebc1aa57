#include "api/memory.h"

#include <doctest/doctest.h>

#include "machine.h"

using meshgauge::api::memory_bytes;
using meshgauge::api::memory_granted;

TEST_CASE("memory: a limit of version 2, of the group or of one above it") {
  const Machine machine("0::/kubepods/pod7/main\n");
  CHECK(memory_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/kubepods/pod7/main/memory.max", "max\n");
  CHECK(memory_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/kubepods/memory.max", "4294967296\n");
  CHECK(memory_granted(machine.root) == 4294967296);
  machine.write("/sys/fs/cgroup/kubepods/pod7/main/memory.max", "1073741824\n");
  CHECK(memory_granted(machine.root) == 1073741824);
  machine.write("/sys/fs/cgroup/kubepods/pod7/memory.high", "536870912\n");
  CHECK(memory_granted(machine.root) == 536870912);
}

TEST_CASE("memory: a limit of version 1, where a huge number is none") {
  const Machine machine("11:memory:/docker/1\n5:cpu,cpuacct:/docker/1\n");
  machine.write("/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  CHECK(memory_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/memory/docker/1/memory.limit_in_bytes", "268435456\n");
  CHECK(memory_granted(machine.root) == 268435456);
}

TEST_CASE("memory: this machine has some") {
  CHECK(memory_bytes() > std::uint64_t{64} << 20);
  CHECK((memory_granted() == 0 || memory_bytes() <= memory_granted()));
}
