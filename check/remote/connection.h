// A connection to the service by libcurl, kept alive between exchanges.
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>

#include <curl/curl.h>

#include "check/remote/exchange.h"
#include "engine/control.h"

namespace meshgauge::check::service {

inline constexpr std::size_t kMostReplyBytes = std::size_t{4} << 20;

struct Access {
  std::string base;  // base_of()
  std::string key;   // empty: none
  bool without_proxy = false;
  std::string ca_file;  // empty: those of this machine
  std::chrono::milliseconds connect_timeout{10'000};
  std::chrono::seconds stall{30};
};

// For one thread at a time. `access` is borrowed.
class Connection {
 public:
  explicit Connection(const Access& access);
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  // Ends soon after `interrupted` says so, which is asked every 10 ms. Holds at most kMostReplyBytes of an answer; what
  // the call's sink takes is not held.
  Exchange send(const Call& call, const Interrupted& interrupted);

 private:
  struct Freed {
    void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
    void operator()(curl_slist* list) const { curl_slist_free_all(list); }
  };
  struct Ended {
    void operator()(CURLM* multi) const { curl_multi_cleanup(multi); }
  };
  using Headers = std::unique_ptr<curl_slist, Freed>;

  void set(const Call& call, const Headers& headers);
  void set_body(const Call& call);
  void set_access();
  std::optional<CURLcode> drive(const Interrupted& interrupted);
  Exchange concluded(CURLcode code, Reply reply);
  std::string why(CURLcode code) const;

  const Access& access_;
  char text_[CURL_ERROR_SIZE] = {};
  std::unique_ptr<CURLM, Ended> multi_;  // owns the connections that are kept; outlives the handle
  std::unique_ptr<CURL, Freed> easy_;
};

}  // namespace meshgauge::check::service
