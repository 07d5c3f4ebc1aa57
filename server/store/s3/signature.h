// AWS Signature Version 4 of requests to S3, in headers. Pure functions over text.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "server/store/s3/settings.h"

namespace meshgauge::server::store {

using NamedTexts = std::vector<std::pair<std::string, std::string>>;

// SHA-256 of the empty text, for requests without a body.
inline constexpr const char* kNoBodySha256 = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

struct UnsignedRequest {
  std::string method;
  std::string host;            // for the header Host: with the port unless it is the scheme's default
  std::string path;            // absolute and encoded, as sent
  NamedTexts query;            // not encoded, in any order
  NamedTexts headers;          // names in lower case, values as sent; all are signed
  std::string payload_sha256;  // of the body, hex
};

// Encodes all but letters, digits and "-._~" as %XX; slashes unless they are kept.
std::string uri_encoded(std::string_view text, bool keep_slashes = false);
// "a=1&uploads=", encoded and in the order of the signature. The request must send this text.
std::string canonical_query(const NamedTexts& query);

// The headers to send: the request's own, x-amz-date, x-amz-content-sha256, x-amz-security-token if there is one, and
// authorization. `date` is "20261122T083000Z".
NamedTexts signed_headers(const UnsignedRequest& request, const S3Credentials& credentials, const std::string& region,
                          const std::string& date);

std::string amz_date_now();

}  // namespace meshgauge::server::store
