#include "server/store/s3/settings.h"

#include <curl/curl.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string_view>

#include "api/base/refused.h"
#include "api/base/utf8.h"

namespace meshgauge::server::store {
namespace {

constexpr std::string_view kScheme = "s3://";
constexpr std::string_view kSmall = "abcdefghijklmnopqrstuvwxyz0123456789";
constexpr std::size_t kMaxPrefix = 512;  // a key may have 1,024 bytes

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

bool is_printable(std::string_view text) {
  return std::all_of(text.begin(), text.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

bool is_made_of(std::string_view text, std::string_view characters) {
  return text.find_first_not_of(characters) == std::string_view::npos;
}

// S3's rules for new buckets. Such names are host names as well.
bool is_bucket(std::string_view name) {
  return name.size() >= 3 && name.size() <= 63 && is_made_of(name, std::string(kSmall) + ".-") &&
         kSmall.find(name.front()) != std::string_view::npos && kSmall.find(name.back()) != std::string_view::npos &&
         name.find("..") == std::string_view::npos;
}

// Refuses "." and "..": software that normalises addresses would read them as other folders.
bool is_prefix(std::string_view prefix) {
  if (prefix.size() > kMaxPrefix) return false;
  if (prefix.empty()) return true;
  for (std::size_t begin = 0; begin <= prefix.size();) {
    const std::size_t end = std::min(prefix.find('/', begin), prefix.size());
    const std::string_view part = prefix.substr(begin, end - begin);
    if (part.empty() || part == "." || part == "..") return false;
    begin = end + 1;
  }
  return find_control(prefix) == std::string::npos;
}

struct Freed {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
};

bool has(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  const bool found = curl_url_get(url, part, &text, 0) == CURLUE_OK;
  curl_free(text);
  return found;
}

Result<std::string> endpoint_of(std::string text) {
  while (!text.empty() && text.back() == '/') text.pop_back();
  const bool web = text.starts_with("http://") || text.starts_with("https://");
  const std::unique_ptr<CURLU, Freed> url(curl_url());
  if (!web || !is_printable(text) || !url || curl_url_set(url.get(), CURLUPART_URL, text.c_str(), 0) != CURLUE_OK) {
    return refused("s3_endpoint must be an address such as https://s3.example.com:9000");
  }
  if (has(url.get(), CURLUPART_USER) || has(url.get(), CURLUPART_PASSWORD)) {
    return refused("s3_endpoint must not contain credentials: set AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY");
  }
  if (text.find('/', text.find("://") + 3) != std::string::npos || has(url.get(), CURLUPART_QUERY) ||
      has(url.get(), CURLUPART_FRAGMENT)) {
    return refused("s3_endpoint must have a scheme, a host and a port alone");
  }
  return text;
}

Result<S3Credentials> credentials_of_environment() {
  S3Credentials found{variable("AWS_ACCESS_KEY_ID"), variable("AWS_SECRET_ACCESS_KEY"), variable("AWS_SESSION_TOKEN")};
  if (found.access_key.empty()) return refused("AWS_ACCESS_KEY_ID is not set, but blobs names a bucket of S3");
  if (found.secret_key.empty()) return refused("AWS_SECRET_ACCESS_KEY is not set, but blobs names a bucket of S3");
  if (!is_printable(found.access_key) || found.access_key.find_first_of("/,") != std::string::npos) {
    return refused("AWS_ACCESS_KEY_ID has invalid characters");
  }
  if (!is_printable(found.secret_key)) return refused("AWS_SECRET_ACCESS_KEY has invalid characters");
  if (!is_printable(found.session_token)) return refused("AWS_SESSION_TOKEN has invalid characters");
  return found;
}

std::string endpoint_of_aws(const std::string& region) {
  return "https://s3." + region + ".amazonaws.com" + (region.starts_with("cn-") ? ".cn" : "");
}

// "s3://BUCKET/PREFIX", in parts.
Result<S3Settings> place_of(const std::string& blobs) {
  if (!blobs.starts_with(kScheme)) return refused("blobs must be empty or s3://BUCKET/PREFIX");
  const std::string path = blobs.substr(kScheme.size());
  const std::size_t slash = path.find('/');
  S3Settings place;
  place.bucket = path.substr(0, slash);
  if (slash != std::string::npos) place.prefix = path.substr(slash + 1);
  while (!place.prefix.empty() && place.prefix.back() == '/') place.prefix.pop_back();
  if (!is_bucket(place.bucket))
    return refused("blobs must name a bucket of S3, with 3 to 63 small letters, digits, dots and hyphens; it names '" +
                   place.bucket + "'");
  if (!is_prefix(place.prefix)) return refused("blobs has an invalid prefix: '" + place.prefix + "'");
  return place;
}

}  // namespace

Result<S3Settings> s3_settings(const std::string& blobs, const std::string& endpoint, const std::string& region,
                               bool virtual_host) {
  Result<S3Settings> settings = place_of(blobs);
  if (!settings) return settings;
  if (region.empty() || region.size() > 64 || !is_made_of(region, std::string(kSmall) + "-")) {
    return refused("s3_region must be the name of a region such as us-east-1");
  }
  Result<std::string> address = endpoint_of(endpoint.empty() ? endpoint_of_aws(region) : endpoint);
  if (!address) return address.error();
  if (virtual_host && address->starts_with("https://") && settings->bucket.find('.') != std::string::npos) {
    return refused("s3_virtual_host needs a bucket without dots: no certificate covers the host name of this one");
  }
  Result<S3Credentials> credentials = credentials_of_environment();
  if (!credentials) return credentials.error();
  settings->endpoint = std::move(*address);
  settings->region = region;
  settings->virtual_host = virtual_host;
  settings->credentials = std::move(*credentials);
  settings->ca_file = variable("AWS_CA_BUNDLE");
  return settings;
}

}  // namespace meshgauge::server::store
