// The bucket of a service with the S3 API, and the key for it.
#pragma once

#include <string>

#include "engine/result.h"

namespace meshgauge::server::store {

struct S3Credentials {
  std::string access_key;
  std::string secret_key;
  std::string session_token;  // empty: none
};

struct S3Settings {
  std::string endpoint;  // "https://host" or "https://host:port", without a trailing slash
  std::string region;
  std::string bucket;
  std::string prefix;         // "" or "some/folder", without leading or trailing slashes
  bool virtual_host = false;  // https://BUCKET.host/KEY instead of https://host/BUCKET/KEY
  S3Credentials credentials;
  std::string ca_file;  // trusted certificates; empty: the system's
};

// Reads the settings `blobs` ("s3://BUCKET/PREFIX"), `s3_endpoint` ("": AWS's of the region), `s3_region` and
// `s3_virtual_host`, and the variables AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN and
// AWS_CA_BUNDLE. Errors (invalid_request) name the setting or variable, and never a secret.
Result<S3Settings> s3_settings(const std::string& blobs, const std::string& endpoint, const std::string& region,
                               bool virtual_host);

}  // namespace meshgauge::server::store
