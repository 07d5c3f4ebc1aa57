// Parses S3's answers, in XML and in headers. The text is not trusted: any other form than the expected one is an
// error.
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
  std::string next;  // the token of the next page; empty: this is the last page
  S3Time now{};      // when the server answered, by its clock, to a second
};

struct ListedUpload {
  std::string key;
  std::string id;
  S3Time begun{};
};

struct UploadsPage {
  std::vector<ListedUpload> uploads;
  std::string next_key, next_id;  // both empty: this is the last page
  S3Time now{};
};

Result<ListPage> list_page_of(const net::HttpAnswer& answer);
Result<UploadsPage> uploads_page_of(const net::HttpAnswer& answer);
Result<std::string> upload_id_of(const net::HttpAnswer& answer);
std::string list_of_parts(const std::vector<std::string>& etags);  // the body that completes an upload of many parts

// Returns the code of a refusal ("SlowDown"), or "". A refusal may come with a status of success, when a long operation
// fails after the head was sent. The code has letters and digits alone, so it may be shown to clients.
std::string error_code_of(const net::HttpAnswer& answer);

// "2026-11-22T08:30:00.000Z", and as in headers: "Sun, 22 Nov 2026 08:30:00 GMT".
Result<S3Time> time_of_xml(const std::string& text);
Result<S3Time> time_of_header(const std::string& text);

}  // namespace meshgauge::server::store
