#include "api/base/machine.h"

#include <sched.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <string>

#include <doctest/doctest.h>

using meshgauge::api::memory_bytes;
using meshgauge::api::memory_granted;
using meshgauge::api::processors;
using meshgauge::api::processors_granted;

namespace {

// The files of a machine with the given control groups; the destructor deletes them.
struct Machine {
  std::string root = (std::filesystem::temp_directory_path() / "meshgauge-groups-XXXXXX").string();

  explicit Machine(const std::string& groups) {
    REQUIRE(::mkdtemp(root.data()) != nullptr);
    write("/proc/self/cgroup", groups);
  }
  ~Machine() { std::filesystem::remove_all(root); }
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  void write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories(std::filesystem::path(root + path).parent_path());
    std::ofstream(root + path) << text;
  }
};

}  // namespace

TEST_CASE("processors: a quota of version 2, of the group or of one above it") {
  const Machine machine("0::/kubepods/pod7/main\n");
  CHECK(processors_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/kubepods/pod7/main/cpu.max", "max 100000\n");
  CHECK(processors_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/kubepods/cpu.max", "1250000 100000\n");
  CHECK(processors_granted(machine.root) == 13);
  machine.write("/sys/fs/cgroup/kubepods/pod7/main/cpu.max", "150000 100000\n");
  CHECK(processors_granted(machine.root) == 2);
  machine.write("/sys/fs/cgroup/cpu.max", "10000 50000\n");
  CHECK(processors_granted(machine.root) == 1);
}

TEST_CASE("processors: a container sees its own group at the root, whatever its path") {
  const Machine machine("0::/system.slice/docker-abc.scope\n");
  machine.write("/sys/fs/cgroup/cpu.max", "300000 100000\n");
  CHECK(processors_granted(machine.root) == 3);
}

TEST_CASE("processors: a quota of version 1") {
  const Machine machine("12:cpuset:/a\n5:cpuacct,cpu:/docker/1\n1:name=systemd:/x\n0::/\n");
  CHECK(processors_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/cpu/docker/1/cpu.cfs_period_us", "100000\n");
  machine.write("/sys/fs/cgroup/cpu/docker/1/cpu.cfs_quota_us", "-1\n");
  CHECK(processors_granted(machine.root) == 0);
  machine.write("/sys/fs/cgroup/cpu/docker/1/cpu.cfs_quota_us", "400000\n");
  CHECK(processors_granted(machine.root) == 4);
}

TEST_CASE("processors: missing and empty files mean no limit") {
  for (const char* groups : {"", "0", "0:", ":::", "0::", "nothing\n0::relative\n"}) {
    const Machine machine(groups);
    machine.write("/sys/fs/cgroup/cpu.max", "zero\n");
    CHECK(processors_granted(machine.root) == 0);
  }
  const Machine machine("0::/\n");
  for (const char* text : {"0 100000", "100000 0", "-5 -5", "nan 100000", "100000", ""}) {
    machine.write("/sys/fs/cgroup/cpu.max", text);
    CHECK(processors_granted(machine.root) == 0);
  }
  CHECK(processors_granted("/no/such/folder") == 0);
}

TEST_CASE("processors: at most those of the CPU affinity") {
  CHECK(processors() >= 1);
  const unsigned bound = std::async(std::launch::async, [] {
                           cpu_set_t all;
                           REQUIRE(::sched_getaffinity(0, sizeof all, &all) == 0);
                           cpu_set_t one;
                           CPU_ZERO(&one);
                           std::size_t first = 0;
                           while (!CPU_ISSET(first, &all)) ++first;
                           CPU_SET(first, &one);
                           REQUIRE(::sched_setaffinity(0, sizeof one, &one) == 0);
                           return processors();
                         }).get();
  CHECK(bound == 1);
}

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
