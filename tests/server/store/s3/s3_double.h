// The test double of S3 (s3_double.py), as a process of its own.
#pragma once

#include <sys/types.h>

#include <string>

#include <nlohmann/json.hpp>

#include "api/base/descriptor.h"
#include "server/store/s3/settings.h"

namespace meshgauge::server::store {

class S3Double {
 public:
  struct Kind {
    std::string token;  // session token that it requires
    bool tls = false;
    bool virtual_host = false;
  };

  S3Double() : S3Double(Kind{}) {}
  explicit S3Double(const Kind& kind);
  ~S3Double();
  S3Double(const S3Double&) = delete;
  S3Double& operator=(const S3Double&) = delete;

  // Settings of a client that it accepts. Keys and prefix have characters that must be encoded.
  S3Settings settings() const;
  // Control.NAME of s3_double.py.
  nlohmann::json control(const std::string& name, const nlohmann::json& value) const;

  // The next `times` requests of this method with a matching path and query fail in this way.
  void fail(const std::string& method, const std::string& match, const std::string& what, unsigned times = 1) const;
  unsigned count(const std::string& method, const std::string& match) const;  // of requests since the last count

 private:
  void start(const std::string& account);

  const Kind kind_;
  std::string certificate_;  // a file with it and its key
  pid_t process_ = -1;
  Descriptor input_;  // its standard input: it ends when this is closed
  int port_ = 0;
};

}  // namespace meshgauge::server::store
