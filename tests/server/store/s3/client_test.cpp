#include "server/store/s3/client.h"

#include <doctest/doctest.h>

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

net::HttpAnswer answer_of(const std::string& text) {
  net::HttpAnswer answer;
  answer.status = 200;
  answer.headers["date"] = "Sun, 22 Nov 2026 08:30:00 GMT";
  answer.body = text;
  return answer;
}

constexpr const char* kObject =
    "<Contents><Key>a&amp;b</Key><LastModified>2026-11-22T08:29:59.250Z</LastModified><Size>12</Size></Contents>";

std::string list_of(const std::string& inside) { return "<ListBucketResult>" + inside + "</ListBucketResult>"; }

}  // namespace

TEST_CASE("answers of S3: a list of objects") {
  const Result<ListPage> page = list_page_of(answer_of(list_of(
      "<IsTruncated>true</IsTruncated><NextContinuationToken>t+/=</NextContinuationToken>" + std::string(kObject))));
  REQUIRE(page.ok());
  REQUIRE(page->objects.size() == 1);
  CHECK(page->objects[0].key == "a&b");
  CHECK(page->objects[0].size == 12);
  CHECK(page->now - page->objects[0].modified == std::chrono::milliseconds(750));
  CHECK(page->next == "t+/=");
  const Result<ListPage> last = list_page_of(answer_of(list_of("<IsTruncated>false</IsTruncated>")));
  CHECK((last.ok() && last->objects.empty() && last->next.empty()));
}

TEST_CASE("answers of S3: an unknown form is an error, not an empty list") {
  const std::string whole = "<IsTruncated>false</IsTruncated>";
  for (const std::string& text :
       {std::string(), std::string("<html><body>It works!</body></html>"), list_of(""),
        list_of("<IsTruncated>x</IsTruncated>"), list_of("<IsTruncated>true</IsTruncated>"),
        list_of(whole).substr(0, 40), list_of(whole + "<Contents><Key>a</Key><Size>1</Size></Contents>"),
        list_of(whole + "<Contents><Key>a</Key><LastModified>2026-11-22T08:29:59Z</LastModified></Contents>"),
        list_of(whole +
                "<Contents><Key>a</Key><LastModified>2026-11-22T08:29:59Z</LastModified><Size>-1</Size></Contents>"),
        list_of(whole + "<Contents><LastModified>2026-11-22T08:29:59Z</LastModified><Size>1</Size></Contents>"),
        std::string("<!DOCTYPE x [<!ENTITY a SYSTEM \"file:///etc/passwd\">]>") +
            list_of(whole + "<Contents><Key></Key><LastModified>&a;</LastModified><Size>1</Size></Contents>")}) {
    CAPTURE(text);
    const Result<ListPage> page = list_page_of(answer_of(text));
    REQUIRE_FALSE(page.ok());
    CHECK(page.error().code == ErrorCode::storage_unavailable);
  }
  net::HttpAnswer timeless = answer_of(list_of(whole));
  timeless.headers.clear();
  CHECK_FALSE(list_page_of(timeless).ok());
  CHECK_FALSE(upload_id_of(answer_of("<InitiateMultipartUploadResult/>")).ok());
  CHECK_FALSE(uploads_page_of(answer_of("<ListMultipartUploadsResult/>")).ok());
}

TEST_CASE("answers of S3: times") {
  CHECK(*time_of_xml("2026-11-22T08:30:00Z") == *time_of_header("Sun, 22 Nov 2026 08:30:00 GMT"));
  CHECK(*time_of_xml("2026-11-22T08:30:00.5Z") - *time_of_xml("2026-11-22T08:30:00.000Z") ==
        std::chrono::milliseconds(500));
  for (const char* text : {"", "yesterday", "2026-13-01T00:00:00Z", "2026-02-30T00:00:00Z", "2026-11-22T25:00:00Z",
                           "2026-11-22T08:30:00", "2026-11-22T08:30:00.xZ"}) {
    CAPTURE(text);
    CHECK_FALSE(time_of_xml(text).ok());
  }
  CHECK_FALSE(time_of_header("").ok());
  CHECK_FALSE(time_of_header("soon").ok());
}

TEST_CASE("answers of S3: the code of a refusal alone") {
  CHECK(error_code_of(answer_of("<Error><Code>SlowDown</Code><Message>x</Message></Error>")) == "SlowDown");
  CHECK(error_code_of(answer_of("<Error><Code>Slow\n<b/>Down</Code></Error>")) == "Slow");
  CHECK(error_code_of(answer_of("<Error><Code>" + std::string(500, 'x') + "</Code></Error>")).size() == 64);
  CHECK(error_code_of(answer_of("<ListBucketResult/>")).empty());
  CHECK(error_code_of(answer_of("")).empty());
}

TEST_CASE("answers of S3: the list of parts is XML whatever the tags are") {
  CHECK(list_of_parts({"\"a<&\"", "b"}).find("<PartNumber>1</PartNumber><ETag>\"a&lt;&amp;\"</ETag>") !=
        std::string::npos);
}
