// Measures gates by a meshgauge service: uploads each file once, requests a batch of comparisons, and follows it to its
// end (openapi.yaml).
//
//   measure -> hash each file once -> HEAD, PUT missing meshes -> POST all pairs -> GET until the end -> Measured
#pragma once

#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "check/measurer.h"
#include "engine/result.h"

namespace meshgauge::check {

struct RemoteOptions {
  std::string url;                // http or https, with a path if the service is below one
  std::string key;                // bearer key; empty: none. Never part of a message
  bool key_in_clear = false;      // permits sending the key over http, where it can be read in transit
  std::filesystem::path ca_file;  // PEM file of the only certificates to trust; empty: those of this machine
  unsigned at_once = 4;           // files sent at the same time, and batches
  // Called with the link of each batch that the service accepts, in the form of Measured::link. From any thread; may
  // be empty; not called for a service without pages.
  std::function<void(const std::string& link)> batch_begun;

  std::chrono::milliseconds connect_timeout{10'000};
  std::chrono::seconds stall{60};  // an exchange without progress for so long has failed
  // The most time to retry transient failures: of a service that has answered before; of one that never has.
  std::chrono::milliseconds retry_time{300'000};
  std::chrono::milliseconds first_contact{10'000};
  std::chrono::milliseconds least_patience{10'000};  // for all tries of a request, if the gate's timeout is shorter
  std::chrono::milliseconds cancel_time{2000};       // for a cancellation to reach the service and to be answered
};

// Creates the measurer; sends nothing before the first measure(). Errors: invalid_request if the URL or the key is
// unusable, or if the key would travel over http to another machine. Uses the proxies of the environment (http_proxy,
// https_proxy, no_proxy), except for a key that goes to this machine over http. Certificates are always checked.
//
// A cancelled measure() ends within about `cancel_time`, with the service's intervals so far. A gate's timeout (at
// least `least_patience`) limits its comparison, all tries of a request together, and the time that an upload may stand
// still, but not an upload that moves. Comparisons that wait for their turn at the service are awaited for
// `retry_time`.
Result<std::unique_ptr<Measurer>> remote(const RemoteOptions& options);

// Returns the key in `file`, without surrounding white space. Without a file: the variable MESHGAUGE_KEY, or an empty
// string.
Result<std::string> service_key(const std::filesystem::path& file);

}  // namespace meshgauge::check
