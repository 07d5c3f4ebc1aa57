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

sigset_t awaited_signals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);
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

enum class Signal { none, end, reload };

// SIGHUP from the kernel: the terminal was closed. Who started the service by nohup wants it to outlive that.
Signal meaning_of_hangup(const siginfo_t& info) {
  if (info.si_code != SI_KERNEL) return Signal::reload;
  struct sigaction started {};
  ::sigaction(SIGHUP, nullptr, &started);
  return started.sa_handler == SIG_IGN ? Signal::none : Signal::end;
}

Signal signalled_within(std::chrono::milliseconds time) {
  const sigset_t set = awaited_signals();
  const timespec wait{0, time.count() * 1'000'000};
  siginfo_t info{};
  const int signal = sigtimedwait(&set, &info, &wait);
  if (signal <= 0) return Signal::none;
  return signal == SIGHUP ? meaning_of_hangup(info) : Signal::end;
}

std::optional<Tls> tls_of(const Settings& settings) {
  if (settings.tls_certificate.empty()) return std::nullopt;
  return std::optional<Tls>(std::in_place, settings.tls_certificate, settings.tls_key);
}

}  // namespace

Service::Service(const Settings& settings, Compare compare)
    : settings_(settings),
      access_(settings.keys_file),
      entrance_(access_, Cors::parse(settings.cors_origins).value()),
      tls_(tls_of(settings)),
      comparisons_(settings, std::move(compare)),
      guard_(
          settings, [this](Exchange& exchange) { entrance_(exchange, router_); }, log_request,
          tls_ ? &*tls_ : nullptr) {
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
  if (auto ok = load_secrets(); !ok) return ok.error();
  const auto port = guard_.bind();
  if (!port) {
    return Error{
        ErrorCode::internal,
        "cannot listen on " + settings_.host + ":" + std::to_string(settings_.port) + ": " + std::strerror(errno), "",
        ""};
  }
  if (auto ok = check_openness(); !ok) return ok.error();
  ended_.store(false);
  listener_ = std::thread([this] {
    guard_.run();
    ended_.store(true);
  });
  while (!guard_.running() && !ended_.load()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return *port;
}

Result<Done> Service::load_secrets() {
  if (auto loaded = access_.reload(); !loaded) return loaded.error();
  if (!tls_) return Done{};
  if (auto loaded = tls_->reload(); !loaded) return loaded.error();
  return Done{};
}

// Asked of the socket, since a name can stand for any address.
Result<Done> Service::check_openness() const {
  if (access_.has_keys() || settings_.public_without_keys || guard_.bound_to_loopback()) return Done{};
  return Error{ErrorCode::invalid_request,
               "other machines can reach " + settings_.host +
                   ": give --keys-file, or say --public-without-keys to serve everybody (MESHGAUGE_KEYS_FILE, "
                   "MESHGAUGE_PUBLIC_WITHOUT_KEYS=true)",
               "", ""};
}

void Service::reload() {
  if (access_.has_keys()) {
    const auto keys = access_.reload();
    log_event("reload",
              keys ? "keys: " + std::to_string(*keys) : keys.error().message + "; the old keys stay in force");
  }
  if (tls_) {
    const auto end = tls_->reload();
    log_event("reload", end ? "certificate valid until " + *end : end.error().message + "; the old certificate stays");
  }
  if (!access_.has_keys() && !tls_) log_event("reload", "there are no keys and no certificate to read");
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
  const sigset_t signals = awaited_signals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  sandbox::Pool pool(pool_settings(settings, parser), [](const std::string& detail) { log_event("sandbox", detail); });
  const auto lacks = pool.start();
  if (!lacks) return lacks.error();
  Service service(settings, comparing_by(pool));
  const auto port = service.start();
  if (!port) return port.error();
  log_listening(settings.host + ":" + std::to_string(*port), settings.simd);
  for (const std::string& lack : *lacks) log_event("sandbox", lack + "; uploads are read with less protection");
  if (!settings.keys_file.empty() && settings.tls_certificate.empty()) {
    log_event("access", "keys are sent in the clear unless a proxy in front speaks TLS");
  }
  for (Signal signal = Signal::none; service.listening() && signal != Signal::end;) {
    signal = signalled_within(kTick);
    if (signal == Signal::reload) service.reload();
  }
  if (!service.listening()) return Error{ErrorCode::internal, "the listening socket failed", "", ""};
  log_event("stopping", "no new work is taken");
  const auto grace_end = Clock::now() + std::chrono::milliseconds(settings.grace_ms);
  service.shutdown(
      [&] { return Clock::now() >= grace_end || signalled_within(std::chrono::milliseconds(0)) == Signal::end; });
  log_event("sandbox", to_string(pool.counters()));
  log_event("stopped", "every request was answered");
  return Done{};
}

}  // namespace meshgauge::server
