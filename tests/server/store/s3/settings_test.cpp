#include "server/store/s3/settings.h"

#include <cstdlib>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

// Sets the variables of AWS, and restores them.
class Environment {
 public:
  Environment() {
    set("AWS_ACCESS_KEY_ID", "AKID");
    set("AWS_SECRET_ACCESS_KEY", "top/secret+");
    set("AWS_SESSION_TOKEN", "");
    set("AWS_CA_BUNDLE", "");
  }
  void set(const char* name, const char* value) { ::setenv(name, value, 1); }
};

std::string refusal(const std::string& blobs, const std::string& endpoint = "", const std::string& region = "us-east-1",
                    bool virtual_host = false) {
  const Result<S3Settings> settings = s3_settings(blobs, endpoint, region, virtual_host);
  if (settings) return "";
  CHECK(settings.error().code == ErrorCode::invalid_request);
  CHECK(settings.error().message.find("secret") == std::string::npos);
  return settings.error().message.substr(0, settings.error().message.find(' '));
}

}  // namespace

TEST_CASE("S3 settings: all are used") {
  Environment environment;
  environment.set("AWS_SESSION_TOKEN", "token");
  environment.set("AWS_CA_BUNDLE", "ca.pem");
  const Result<S3Settings> settings =
      s3_settings("s3://my-bucket/some/folder/", "https://s3.example.com:9000/", "eu-west-3", true);
  REQUIRE(settings.ok());
  CHECK(settings->bucket == "my-bucket");
  CHECK(settings->prefix == "some/folder");
  CHECK(settings->endpoint == "https://s3.example.com:9000");
  CHECK(settings->region == "eu-west-3");
  CHECK(settings->virtual_host);
  CHECK(settings->credentials.access_key == "AKID");
  CHECK(settings->credentials.secret_key == "top/secret+");
  CHECK(settings->credentials.session_token == "token");
  CHECK(settings->ca_file == "ca.pem");
}

TEST_CASE("S3 settings: defaults") {
  const Environment environment;
  const Result<S3Settings> settings = s3_settings("s3://bucket", "", "us-east-1", false);
  REQUIRE(settings.ok());
  CHECK(settings->prefix.empty());
  CHECK(settings->endpoint == "https://s3.us-east-1.amazonaws.com");
  CHECK(s3_settings("s3://bucket", "", "cn-north-1", false)->endpoint == "https://s3.cn-north-1.amazonaws.com.cn");
  CHECK(s3_settings("s3://bucket", "http://[::1]:9000", "us-east-1", false)->endpoint == "http://[::1]:9000");
}

TEST_CASE("S3 settings: invalid values are refused by name") {
  Environment environment;
  for (const char* blobs :
       {"", "bucket", "S3://bucket", "s3://", "s3://ab", "s3://Bucket", "s3://buc ket", "s3://bu..ket", "s3://-bucket",
        "s3://bucket-", "s3:///x", "s3://bucket//x", "s3://bucket/../x", "s3://bucket/a/./b", "s3://bucket/a\nb"}) {
    CAPTURE(blobs);
    CHECK(refusal(blobs) == "blobs");
  }
  CHECK(refusal("s3://bucket/" + std::string(513, 'a')) == "blobs");
  for (const char* endpoint : {"s3.example.com", "ftp://host", "http://", "https://host/path", "https://host?x=1",
                               "https://user:pw@host", "https://ho st", "https://host#x", "https://host:99999"}) {
    CAPTURE(endpoint);
    CHECK(refusal("s3://bucket", endpoint) == "s3_endpoint");
  }
  for (const char* region : {"", "us east", "US-EAST-1", "us/east"}) {
    CAPTURE(region);
    CHECK(refusal("s3://bucket", "", region) == "s3_region");
  }
  CHECK(refusal("s3://my.bucket", "https://host", "us-east-1", true) == "s3_virtual_host");
  CHECK(refusal("s3://my.bucket", "http://host", "us-east-1", true).empty());
  environment.set("AWS_SECRET_ACCESS_KEY", "");
  CHECK(refusal("s3://bucket") == "AWS_SECRET_ACCESS_KEY");
  environment.set("AWS_SECRET_ACCESS_KEY", "secret\n");
  CHECK(refusal("s3://bucket") == "AWS_SECRET_ACCESS_KEY");
  environment.set("AWS_ACCESS_KEY_ID", "a/b");
  CHECK(refusal("s3://bucket") == "AWS_ACCESS_KEY_ID");
  environment.set("AWS_ACCESS_KEY_ID", "");
  CHECK(refusal("s3://bucket") == "AWS_ACCESS_KEY_ID");
}
