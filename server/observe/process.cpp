#include "server/observe/process.h"

#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

namespace meshgauge::server {
namespace {

double seconds_of(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// The fields of /proc/self/stat from the third on: the second is the program's name, which may hold anything.
std::vector<std::string> stat_fields() {
  std::ifstream file("/proc/self/stat");
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  std::istringstream rest(text.substr(text.rfind(')') + 1));
  return {std::istream_iterator<std::string>(rest), {}};
}

std::uint64_t number(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

void read_stat(ProcessFacts& facts) {
  const auto fields = stat_fields();
  constexpr std::size_t kThreads = 17, kVirtual = 20, kResident = 21;  // proc(5), less three
  if (fields.size() <= kResident) return;
  facts.threads = number(fields[kThreads]);
  facts.virtual_bytes = number(fields[kVirtual]);
  facts.resident_bytes = number(fields[kResident]) * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

const auto kStarted = std::chrono::system_clock::now();  // before main()

}  // namespace

ProcessFacts process_facts() {
  ProcessFacts facts;
  facts.started = std::chrono::duration<double>(kStarted.time_since_epoch()).count();
  read_stat(facts);
  std::error_code error;
  const std::filesystem::directory_iterator open("/proc/self/fd", error);
  // Less the descriptor of the iterator itself.
  if (!error) facts.open_descriptors = static_cast<std::uint64_t>(std::distance(begin(open), end(open))) - 1;
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) == 0) facts.most_descriptors = limit.rlim_cur;
  rusage usage{};
  if (::getrusage(RUSAGE_SELF, &usage) == 0)
    facts.cpu_seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
  return facts;
}

}  // namespace meshgauge::server
