#include "api/processors.h"

#include <sched.h>

#include <future>

#include <doctest/doctest.h>

#include "machine.h"

using meshgauge::api::processors;
using meshgauge::api::processors_granted;

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
