// Gates measured by a meshgauge service: files travel there once, comparisons are asked for and followed, many as a
// batch (openapi.yaml).
//
//   measure -> hash each file once -> HEAD, PUT what is not there -> POST the pair, or all pairs -> GET until it has
//   ended -> Measured
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
  std::string url;                // http or https, with a path where the service stands below one
  std::string key;                // bearer key; empty: none. In no message
  bool key_in_clear = false;      // the key may travel by http, where whoever is on the way reads it
  std::filesystem::path ca_file;  // certificates to trust, PEM, and no others; empty: those of this machine
  unsigned at_once = 4;           // gates at the same time; fewer while the service refuses more
  // Told of each batch, when the service has accepted it: the link to its page there, as Measured::link. From any
  // thread; may be empty, and is not called for a service without pages.
  std::function<void(const std::string& link)> batch_begun;

  std::chrono::milliseconds connect_timeout{10'000};
  std::chrono::seconds stall{60};  // an exchange that hardly moves for so long has failed
  // How long what may pass is tried again: a service that was reached before; one that never was.
  std::chrono::milliseconds patience{300'000};
  std::chrono::milliseconds first_contact{10'000};
};

// invalid_request when the URL or the key cannot be used, or when the key would be readable on its way to another
// machine. Nothing is sent before the first measure(). Proxies are those of the environment (http_proxy, https_proxy,
// no_proxy), but a key that goes to this machine by http passes none; certificates are always checked.
//
// Cancelled, measure() ends within about two seconds, with the interval that the service had reached. The gate's
// timeout is that of the comparison, the way of the files not counted; an answer that does not come in spite of it is
// waited for as long as `patience` says.
Result<std::unique_ptr<Measurer>> remote(const RemoteOptions& options);

// The key in that file, without the white space around it; without a file that of the variable MESHGAUGE_KEY, or none.
Result<std::string> service_key(const std::filesystem::path& file);

}  // namespace meshgauge::check
