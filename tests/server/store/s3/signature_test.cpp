// The examples of "Signature Calculations for the Authorization Header" in AWS's reference of S3.
#include "server/store/s3/signature.h"

#include <doctest/doctest.h>

using namespace meshgauge::server::store;

namespace {

const S3Credentials kExample{"AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", ""};
constexpr const char* kHost = "examplebucket.s3.amazonaws.com";
constexpr const char* kDate = "20130524T000000Z";

std::string header(const NamedTexts& headers, const std::string& wanted) {
  for (const auto& [name, value] : headers) {
    if (name == wanted) return value;
  }
  return "";
}

std::string signature_of(const UnsignedRequest& request, const S3Credentials& credentials = kExample) {
  const std::string line = header(signed_headers(request, credentials, "us-east-1", kDate), "authorization");
  return line.substr(line.find("Signature=") + 10);
}

}  // namespace

TEST_CASE("signature: the examples of AWS") {
  CHECK(signature_of({"GET", kHost, "/test.txt", {}, {{"range", "bytes=0-9"}}, kNoBodySha256}) ==
        "f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41");
  CHECK(signature_of({"PUT",
                      kHost,
                      "/" + uri_encoded("test$file.text"),
                      {},
                      {{"date", "Fri, 24 May 2013 00:00:00 GMT"}, {"x-amz-storage-class", "REDUCED_REDUNDANCY"}},
                      "44ce7dd67c959e0d3524ffac1771dfbba87d2b6b4b4e99e42034a8b803f8b072"}) ==
        "98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd");
  CHECK(signature_of({"GET", kHost, "/", {{"lifecycle", ""}}, {}, kNoBodySha256}) ==
        "fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543");
  CHECK(signature_of({"GET", kHost, "/", {{"prefix", "J"}, {"max-keys", "2"}}, {}, kNoBodySha256}) ==
        "34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7");
}

TEST_CASE("signature: the header names the signed headers") {
  const NamedTexts headers = signed_headers({"GET", kHost, "/", {}, {{"range", "bytes=1-"}}, kNoBodySha256},
                                            {"AKID", "secret", "to/ken=="}, "eu-west-3", kDate);
  CHECK(header(headers, "authorization")
            .starts_with("AWS4-HMAC-SHA256 Credential=AKID/20130524/eu-west-3/s3/aws4_request,"
                         "SignedHeaders=host;range;x-amz-content-sha256;x-amz-date;x-amz-security-token,Signature="));
  CHECK(header(headers, "x-amz-security-token") == "to/ken==");
  CHECK(header(headers, "x-amz-date") == kDate);
  CHECK(header(headers, "x-amz-content-sha256") == kNoBodySha256);
  CHECK(header(headers, "host").empty());  // the sender writes it
}

TEST_CASE("signature: encoding and order of a query") {
  CHECK(uri_encoded("aZ09-._~") == "aZ09-._~");
  CHECK(uri_encoded("a b+c/d%é") == "a%20b%2Bc%2Fd%25%C3%A9");
  CHECK(uri_encoded("a/b c", true) == "a/b%20c");
  CHECK(canonical_query({}).empty());
  CHECK(canonical_query({{"uploads", ""}, {"prefix", "a/&="}, {"Zone", "1"}, {"a", "2"}, {"a", "1"}}) ==
        "Zone=1&a=1&a=2&prefix=a%2F%26%3D&uploads=");
  CHECK(amz_date_now().size() == 16);
}
