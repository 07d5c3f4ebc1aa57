// A pool whose workers read, or do the harm that their file names (hostile.cpp).
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <future>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include <doctest/doctest.h>

#include "server/sandbox/confine.h"
#include "server/sandbox/pool.h"
#include "server/sandbox/processes.h"
#include "tests/eventually.h"

namespace meshgauge::server::sandbox {

inline constexpr std::string_view kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
inline constexpr std::uint64_t kMemoryMiB = 512;

inline std::string beside_this_program(const std::string& name) {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / name;
}

inline std::string hostile_program() { return beside_this_program("sandbox_hostile"); }

struct Sandbox {
  explicit Sandbox(std::vector<std::string> command = {hostile_program()}, std::size_t parsers = 2,
                   std::uint64_t cpu_seconds = 100)
      : pool({std::move(command), parsers, {kMemoryMiB << 20, 1 << 20, cpu_seconds, true}},
             [this](const std::string& detail) {
               const std::lock_guard lock(mutex);
               log += detail + "\n";
             }) {}

  void start() { REQUIRE(pool.start().ok()); }

  Result<api::LoadedMesh> read(std::string_view text, Control& control, const api::ReadLimits& limits = {},
                               Memory* memory = nullptr) {
    return pool.load({"a", std::as_bytes(std::span(text)), "a.obj", ""}, limits, control, memory);
  }
  Result<api::LoadedMesh> read(std::string_view text) {
    Control control;
    return read(text, control);
  }
  bool works() {
    const auto mesh = read(kTriangle);
    return mesh && mesh->mesh.positions.size() == 3 && mesh->mesh.triangles.size() == 1;
  }
  std::string logged() {
    const std::lock_guard lock(mutex);
    return log;
  }

  std::mutex mutex;
  std::string log;
  Pool pool;
};

// A reading that goes on until it is cancelled.
class Endless {
 public:
  explicit Endless(Sandbox& sandbox, Memory* memory = nullptr)
      : reading_(std::async(std::launch::async,
                            [this, &sandbox, memory] { return sandbox.read("loop", control_, {}, memory); })) {}
  Endless(const Endless&) = delete;
  Endless& operator=(const Endless&) = delete;
  ~Endless() { control_.cancel(); }  // a test that fails half-way must not wait for it
  Result<api::LoadedMesh> result() { return reading_.get(); }
  Control& control() { return control_; }

 private:
  Control control_;
  std::future<Result<api::LoadedMesh>> reading_;
};

// The workers that have computed for a while: not one that was just made.
inline std::vector<Process> running() {
  auto all = workers();
  std::erase_if(all, [](const Process& p) { return p.state != 'R' || p.ticks < 5; });
  return all;
}

inline void check_refused(const Result<api::LoadedMesh>& read, ErrorCode code) {
  REQUIRE(!read.ok());
  CHECK(read.error().code == code);
  CHECK(read.error().part == "a");
  CHECK(read.error().message.starts_with("'a' "));
}

}  // namespace meshgauge::server::sandbox
