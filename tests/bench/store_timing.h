// Helpers of the stores' benchmarks: unwrapping of results, jobs of typical size, calls for each second.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "api/base/digest.h"
#include "server/store/job_store.h"

namespace meshgauge::server::store {

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

template <class T>
T got(Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "bench: %s\n", result.error().message.c_str());
  std::exit(1);
}

inline NewJob new_job(const std::string& owner, const std::string& id) {
  NewJob job;
  job.key = {owner, id};
  job.mesh_a = job.mesh_b = std::string(64, 'a');
  job.hints = R"({"a":"left.stl","b":"right.stl"})";
  job.options = R"({"tolerance":{"relative":0.01}})";
  job.fingerprint = std::string(64, 'f');
  job.created = now();
  job.expires_if_never_run = job.created + std::chrono::hours(1);
  return job;
}

// Random digits, which a database cannot compress.
inline const std::string& usual_document() {
  static const std::string document = [] {
    std::string digits;
    while (digits.size() < 2500) digits += api::random_id();
    return digits;
  }();
  return document;
}

// Calls work() on `threads` threads for the given time and adds up the counts that it returns. Returns counts a second.
inline double rate(int threads, double seconds, const std::function<std::uint64_t()>& work) {
  std::atomic<std::uint64_t> counts{0};
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::thread> pool;
  for (int i = 0; i < threads; ++i) {
    pool.emplace_back([&] {
      while (seconds_since(start) < seconds) counts.fetch_add(work());
    });
  }
  for (std::thread& thread : pool) thread.join();
  return static_cast<double>(counts.load()) / seconds_since(start);
}

}  // namespace meshgauge::server::store
