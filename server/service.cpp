#include "server/service.h"

#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "server/log.h"
#include "server/openapi.h"
#include "server/sandbox/pool.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kTick{50};

void send(Exchange& exchange, std::string text, const char* type) {
  exchange.response = {200, type, std::move(text), {}};
}

Result<Done> check_temp_dir(const std::string& directory) {
  const int file = open_unnamed_file(directory);
  if (file < 0) {
    return Error{ErrorCode::invalid_request, "--temp-dir '" + directory + "' takes no files: " + std::strerror(errno),
                 "", ""};
  }
  ::close(file);
  return Done{};
}

sigset_t ending_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  return set;
}

sandbox::PoolSettings pool_settings(const Settings& settings, const std::vector<std::string>& command) {
  sandbox::Bounds bounds;
  bounds.memory_bytes = settings.parser_memory_bytes;
  bounds.input_bytes = settings.max_part_bytes;
  bounds.cpu_seconds = settings.max_timeout_ms / 1000 + 2;  // a second net: the deadline comes first
  return {command, settings.parsers, bounds};
}

// What `pool` reads is measured as what api::load() reads.
Compare comparing_by(sandbox::Pool& pool) {
  const api::Load load = [&pool](const api::MeshInput& input, const api::ReadLimits& limits, Control& control) {
    return pool.load(input, limits, control);
  };
  return [load](const api::MeshInput& a, const api::MeshInput& b, const Options& options, const api::ReadLimits& limits,
                Control& control) { return api::compare_by(load, a, b, options, limits, control); };
}

bool signalled_within(std::chrono::milliseconds time) {
  const sigset_t set = ending_signals();
  const timespec wait{0, time.count() * 1'000'000};
  return sigtimedwait(&set, nullptr, &wait) > 0;
}

}  // namespace

Service::Service(const Settings& settings, Compare compare)
    : settings_(settings),
      comparisons_(settings, std::move(compare)),
      guard_(
          settings, [this](Exchange& exchange) { router_(exchange); }, log_request) {
  add_routes();
}

Service::~Service() {
  shutdown([] { return true; });
}

void Service::add_routes() {
  router_.add("GET", "/", [](Exchange& e) {
    send(e, std::string("meshgauge ") + version() + "\nPOST /v1/comparisons, described by /openapi.yaml\n",
         "text/plain");
  });
  router_.add("GET", "/healthz", [](Exchange& e) {
    send(e, std::string(R"({"status":"ok","version":")") + version() + "\"}", "application/json");
  });
  router_.add("GET", "/openapi.yaml", [](Exchange& e) { send(e, std::string(openapi_yaml()), "application/yaml"); });
  router_.add("POST", "/v1/comparisons", [this](Exchange& e) { comparisons_.create(e); });
}

Result<int> Service::start() {
  if (auto ok = check_temp_dir(settings_.temp_dir); !ok) return ok.error();
  const auto port = guard_.bind();
  if (!port) {
    return Error{
        ErrorCode::internal,
        "cannot listen on " + settings_.host + ":" + std::to_string(settings_.port) + ": " + std::strerror(errno), "",
        ""};
  }
  ended_.store(false);
  listener_ = std::thread([this] {
    guard_.run();
    ended_.store(true);
  });
  while (!guard_.running() && !ended_.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return *port;
}

void Service::shutdown(const std::function<bool()>& hurry) {
  if (!listener_.joinable()) return;
  comparisons_.refuse_new();
  guard_.stop();
  while (!ended_.load() && !hurry()) std::this_thread::sleep_for(kTick);
  comparisons_.cancel_all();
  guard_.abort();
  listener_.join();
}

Result<Done> run_until_signal(const Settings& settings, const std::vector<std::string>& parser) {
  const sigset_t signals = ending_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  sandbox::Pool pool(pool_settings(settings, parser), [](const std::string& detail) { log_event("sandbox", detail); });
  const auto lacks = pool.start();
  if (!lacks) return lacks.error();
  Service service(settings, comparing_by(pool));
  const auto port = service.start();
  if (!port) return port.error();
  log_listening(settings.host + ":" + std::to_string(*port), settings.simd);
  for (const std::string& lack : *lacks) log_event("sandbox", lack + "; uploads are read with less protection");
  while (service.listening() && !signalled_within(kTick)) {
  }
  const bool failed = !service.listening();  // then a supervisor is to start the service anew
  log_event("stopping", failed ? "the listening socket failed" : "no new work is taken");
  const auto grace_end = Clock::now() + std::chrono::milliseconds(settings.grace_ms);
  service.shutdown([&] { return Clock::now() >= grace_end || signalled_within(std::chrono::milliseconds(0)); });
  log_event("sandbox", to_string(pool.counters()));
  log_event("stopped", "every request was answered");
  if (failed) return Error{ErrorCode::internal, "the listening socket failed", "", ""};
  return Done{};
}

}  // namespace meshgauge::server
