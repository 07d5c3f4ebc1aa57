// Reads what to measure as JSON from standard input, and writes what became of it. Ctrl-C as with `meshgauge check`.
//
//   {"service": null | {"url", "key_file", "ca_file", "at_once", "connect_timeout_ms", "stall_s",
//                         "retry_ms", "first_contact_ms", "patience_ms", "cancel_ms"},
//    "gates": [{"name", "candidate", "baseline", "options"}]}
#include <csignal>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "api/options/request.h"
#include "check/remote.h"
#include "check/run/local.h"
#include "check/run/meshes.h"
#include "check/run/run.h"

namespace {

using namespace meshgauge;
using Json = nlohmann::ordered_json;

volatile std::sig_atomic_t interrupted = 0;

check::Gate gate_of(const Json& json) {
  check::Gate gate;
  gate.name = json.at("name");
  gate.candidate = json.at("candidate").get<std::string>();
  gate.baseline = json.at("baseline").get<std::string>();
  const auto request = api::parse_options(json.at("options").dump());
  if (!request) throw std::runtime_error(request.error().message);
  gate.request = *request;
  return gate;
}

std::unique_ptr<check::Measurer> remote_of(const Json& json) {
  const auto key = check::service_key(json.value("key_file", ""));
  if (!key) throw std::runtime_error(key.error().message);
  check::RemoteOptions options;
  options.url = json.at("url");
  options.key = *key;
  options.ca_file = json.value("ca_file", "");
  options.at_once = json.value("at_once", options.at_once);
  options.retry_time = std::chrono::milliseconds(json.value("retry_ms", options.retry_time.count()));
  options.first_contact = std::chrono::milliseconds(json.value("first_contact_ms", options.first_contact.count()));
  options.least_patience = std::chrono::milliseconds(json.value("patience_ms", options.least_patience.count()));
  options.connect_timeout =
      std::chrono::milliseconds(json.value("connect_timeout_ms", options.connect_timeout.count()));
  options.cancel_time = std::chrono::milliseconds(json.value("cancel_ms", options.cancel_time.count()));
  options.stall = std::chrono::seconds(json.value("stall_s", options.stall.count()));
  auto made = check::remote(options);
  if (!made) throw std::runtime_error(made.error().message);
  return std::move(*made);
}

std::unique_ptr<check::Measurer> measurer_of(const Json& service, const std::vector<check::Gate>& gates) {
  if (!service.is_null()) return remote_of(service);
  return check::local(gates, std::make_shared<check::Meshes>(gates), {1, 1});
}

Json told(const check::GateOutcome& outcome) {
  Json json{{"name", outcome.gate.name},
            {"verdict", to_string(outcome.verdict())},
            {"interrupted", outcome.interrupted},
            {"limit", nullptr},
            {"document", nullptr},
            {"error", nullptr},
            {"part", nullptr}};
  if (outcome.measured) {
    json["document"] = outcome.measured->document;
    json["limit"] = outcome.measured->criteria.front().limit;
    json["link"] = outcome.measured->link;
  }
  if (outcome.error) {
    json["error"] = outcome.error->message;
    json["part"] = outcome.error->part;
  }
  return json;
}

// The most memory that this process has had. What getrusage() says counts the process that started it as well.
std::size_t peak_bytes() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    std::size_t kibibytes = 0;
    if (word == "VmHWM:" && status >> kibibytes) return kibibytes << 10;
  }
  return 0;
}

Json measure(const Json& asked) {
  std::vector<check::Gate> gates;
  for (const Json& gate : asked.at("gates")) gates.push_back(gate_of(gate));
  const auto measurer = measurer_of(asked.at("service"), gates);
  check::Watch watch;
  watch.interrupted = [] { return interrupted != 0; };
  watch.standing = [](const check::Standing& standing) {
    for (const check::Running& gate : standing.running) {
      std::fprintf(stderr, "%s %s %.17g %.17g\n", gate.gate->name.c_str(), gate.progress.stage, gate.progress.lower,
                   gate.progress.upper);
    }
  };
  Json outcomes = Json::array();
  for (const auto& outcome : check::run(gates, *measurer, watch).outcomes) outcomes.push_back(told(outcome));
  return {{"outcomes", outcomes}, {"peak_bytes", peak_bytes()}};
}

}  // namespace

int main() try {
  std::signal(SIGINT, [](int) { interrupted = 1; });
  const std::string text((std::istreambuf_iterator<char>(std::cin)), std::istreambuf_iterator<char>());
  std::cout << measure(Json::parse(text)).dump() << '\n';
  return 0;
} catch (const std::exception& error) {
  std::cout << Json{{"refused", error.what()}}.dump() << '\n';
  return 3;
}
