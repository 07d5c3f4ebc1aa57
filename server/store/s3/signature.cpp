#include "server/store/s3/signature.h"

#include <openssl/evp.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <stdexcept>

#include "api/base/digest.h"
#include "api/base/text.h"
#include "api/base/utc.h"

namespace meshgauge::server::store {
namespace {

constexpr const char* kAlgorithm = "AWS4-HMAC-SHA256";

std::string hmac(std::string_view key, std::string_view text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  const auto* bytes = reinterpret_cast<const unsigned char*>(text.data());
  if (HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), bytes, text.size(), digest.data(), &size) ==
      nullptr) {
    throw std::runtime_error("the cryptographic library has no HMAC");
  }
  return {reinterpret_cast<const char*>(digest.data()), size};
}

std::string sha256(std::string_view text) { return api::sha256_hex(std::as_bytes(std::span(text))); }

// Removes spaces at the ends; runs of spaces become one.
std::string canonical_value(std::string_view value) {
  std::string text;
  for (const char c : value) {
    if (c != ' ' || (!text.empty() && text.back() != ' ')) text += c;
  }
  if (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string names_of(const NamedTexts& headers) {
  std::string names;
  for (const auto& [name, value] : headers) names += (names.empty() ? "" : ";") + name;
  return names;
}

std::string canonical_request(const UnsignedRequest& request, const NamedTexts& headers) {
  std::string text = request.method + "\n" + request.path + "\n" + canonical_query(request.query) + "\n";
  for (const auto& [name, value] : headers) text += name + ":" + canonical_value(value) + "\n";
  return text + "\n" + names_of(headers) + "\n" + request.payload_sha256;
}

std::string signing_key(const std::string& secret, const std::string& day, const std::string& region) {
  return hmac(hmac(hmac(hmac("AWS4" + secret, day), region), "s3"), "aws4_request");
}

}  // namespace

std::string uri_encoded(std::string_view text, bool keep_slashes) {
  return api::percent_encoded(text, keep_slashes ? "-._~/" : "-._~");
}

std::string canonical_query(const NamedTexts& query) {
  NamedTexts encoded;
  for (const auto& [name, value] : query) encoded.emplace_back(uri_encoded(name), uri_encoded(value));
  std::sort(encoded.begin(), encoded.end());
  std::string text;
  for (const auto& [name, value] : encoded) text += (text.empty() ? "" : "&") + name + "=" + value;
  return text;
}

NamedTexts signed_headers(const UnsignedRequest& request, const S3Credentials& credentials, const std::string& region,
                          const std::string& date) {
  NamedTexts headers = request.headers;
  headers.emplace_back("x-amz-content-sha256", request.payload_sha256);
  headers.emplace_back("x-amz-date", date);
  if (!credentials.session_token.empty()) headers.emplace_back("x-amz-security-token", credentials.session_token);
  NamedTexts with_host = headers;
  with_host.emplace_back("host", request.host);
  std::sort(with_host.begin(), with_host.end());

  const std::string day = date.substr(0, 8);
  const std::string scope = day + "/" + region + "/s3/aws4_request";
  const std::string to_sign =
      std::string(kAlgorithm) + "\n" + date + "\n" + scope + "\n" + sha256(canonical_request(request, with_host));
  const std::string signature = hmac(signing_key(credentials.secret_key, day, region), to_sign);
  headers.emplace_back("authorization", std::string(kAlgorithm) + " Credential=" + credentials.access_key + "/" +
                                            scope + ",SignedHeaders=" + names_of(with_host) +
                                            ",Signature=" + api::to_hex(std::as_bytes(std::span(signature))));
  return headers;
}

std::string amz_date_now() {
  std::string text = api::to_utc(std::chrono::system_clock::now());
  std::erase_if(text, [](char c) { return c == '-' || c == ':'; });
  return text;
}

}  // namespace meshgauge::server::store
