// What S3 answers, in XML and in headers, as values. Its text is not trusted: what is not of the expected form is an
// error, never a guess.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "engine/result.h"
#include "net/http_client.h"

namespace meshgauge::server::store {

using S3Time = std::chrono::sys_time<std::chrono::milliseconds>;

struct ListedObject {
  std::string key;
  std::uint64_t size = 0;
  S3Time modified{};
};

struct ListPage {
  std::vector<ListedObject> objects;
  std::string next;  // the token of the next page; empty: this is the last
  S3Time now{};      // when the server answered, by its clock, of which a second is not known
};

struct ListedUpload {
  std::string key;
  std::string id;
  S3Time begun{};
};

struct UploadsPage {
  std::vector<ListedUpload> uploads;
  std::string next_key, next_id;  // both empty: this is the last
  S3Time now{};
};

Result<ListPage> list_page_of(const net::HttpAnswer& answer);
Result<UploadsPage> uploads_page_of(const net::HttpAnswer& answer);
Result<std::string> upload_id_of(const net::HttpAnswer& answer);
std::string list_of_parts(const std::vector<std::string>& etags);  // the body that completes an upload of many parts

// The code that the server gives its refusal ("SlowDown"), also when the status says that all is well, as it does when
// a long operation fails after the head was sent; else "". Letters and digits, so that it may be shown to anybody.
std::string error_code_of(const net::HttpAnswer& answer);

// "2026-11-22T08:30:00.000Z", and as in headers: "Sun, 22 Nov 2026 08:30:00 GMT".
Result<S3Time> time_of_xml(const std::string& text);
Result<S3Time> time_of_header(const std::string& text);

}  // namespace meshgauge::server::store
