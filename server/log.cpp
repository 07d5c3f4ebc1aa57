#include "server/log.h"

#include <unistd.h>

#include <array>
#include <ctime>

#include <nlohmann/json.hpp>

namespace meshgauge::server {
namespace {

using Json = nlohmann::ordered_json;

std::string utc_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  std::tm parts{};
  gmtime_r(&now.tv_sec, &parts);
  std::array<char, 40> text{};
  const std::size_t n = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text.data() + n, text.size() - n, ".%03ldZ", now.tv_nsec / 1'000'000);
  return text.data();
}

// One write a line, so that the lines of several threads do not mix.
void write_line(const Json& json) {
  const std::string line = json.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace

void log_request(const Exchange& exchange) {
  Json json{{"time", utc_now()},
            {"event", "request"},
            {"id", exchange.id},
            {"method", exchange.head.method},
            {"path", exchange.head.path},
            {"status", exchange.response.status},
            {"bytes", exchange.body.bytes()}};
  if (!exchange.owner.empty()) json["key"] = exchange.owner;
  if (!exchange.problem.empty()) json["problem"] = exchange.problem;
  if (!exchange.failure.empty()) json["failure"] = exchange.failure;
  if (exchange.triangles) json["triangles"] = {{"a", exchange.triangles->a}, {"b", exchange.triangles->b}};
  if (!exchange.stages.empty()) json["stages"] = exchange.stages;
  write_line(json);
}

void log_listening(const std::string& address, const std::string& simd) {
  write_line({{"time", utc_now()}, {"event", "listening"}, {"detail", address}, {"simd", simd}});
}

void log_event(const std::string& event, const std::string& detail) {
  write_line({{"time", utc_now()}, {"event", event}, {"detail", detail}});
}

}  // namespace meshgauge::server
