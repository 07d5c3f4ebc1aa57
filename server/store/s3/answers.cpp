#include "server/store/s3/answers.h"

#include <curl/curl.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <pugixml.hpp>
#include <sstream>
#include <string_view>

#include "api/utc.h"

namespace meshgauge::server::store {
namespace {

constexpr std::size_t kMaxCode = 64;

Error not_understood(const char* what) {
  return {ErrorCode::storage_unavailable, std::string("S3 sent an answer of unknown form: ") + what, "", ""};
}

// pugixml knows only XML's own entities and loads nothing, so a hostile text can only fail.
std::optional<pugi::xml_document> parsed_xml(const std::string& text) {
  pugi::xml_document document;
  if (!document.load_buffer(text.data(), text.size())) return std::nullopt;
  return document;
}

std::string text_of(const pugi::xml_node& node, const char* name) { return node.child_value(name); }

std::optional<std::uint64_t> number_of(const std::string& text) {
  std::uint64_t number = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (failed != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return number;
}

// Whether there are more pages; an error if that is unclear, so that half a list never counts as the whole.
Result<bool> is_truncated(const pugi::xml_node& root) {
  const std::string text = text_of(root, "IsTruncated");
  if (text == "true") return true;
  if (text == "false") return false;
  return not_understood("a list that does not say whether it is complete");
}

Result<ListedObject> object_of(const pugi::xml_node& node) {
  ListedObject object;
  object.key = text_of(node, "Key");
  const std::optional<std::uint64_t> size = number_of(text_of(node, "Size"));
  const Result<S3Time> modified = time_of_xml(text_of(node, "LastModified"));
  if (object.key.empty() || !size) return not_understood("a listed object without a key or a size");
  if (!modified) return modified.error();
  object.size = *size;
  object.modified = *modified;
  return object;
}

Result<ListedUpload> upload_of(const pugi::xml_node& node) {
  ListedUpload upload{text_of(node, "Key"), text_of(node, "UploadId"), {}};
  const Result<S3Time> begun = time_of_xml(text_of(node, "Initiated"));
  if (upload.key.empty() || upload.id.empty()) return not_understood("a listed upload without a key or an id");
  if (!begun) return begun.error();
  upload.begun = *begun;
  return upload;
}

}  // namespace

// Seconds with up to three digits of a fraction: "2009-10-12T17:50:30.000Z".
Result<S3Time> time_of_xml(const std::string& text) {
  const std::size_t whole = std::min(text.find_first_of(".Z"), text.size());
  const std::string fraction = text.substr(whole, text.find('Z') - whole);
  const auto seconds = api::parse_utc(text.substr(0, whole) + "Z");
  const auto milli = number_of(((fraction.empty() ? "" : fraction.substr(1)) + "000").substr(0, 3));
  if (!seconds || !milli || !text.ends_with('Z') || fraction == ".") return not_understood("a time");
  return std::chrono::floor<std::chrono::milliseconds>(*seconds) + std::chrono::milliseconds(*milli);
}

Result<S3Time> time_of_header(const std::string& text) {
  const std::time_t seconds = text.empty() ? -1 : curl_getdate(text.c_str(), nullptr);
  if (seconds < 0) return not_understood("a date");
  return S3Time(std::chrono::seconds(seconds));
}

Result<ListPage> list_page_of(const net::HttpAnswer& answer) {
  const auto document = parsed_xml(answer.body);
  const pugi::xml_node root = document ? document->child("ListBucketResult") : pugi::xml_node();
  if (!root) return not_understood("no list of objects");
  ListPage page;
  for (const pugi::xml_node& node : root.children("Contents")) {
    Result<ListedObject> object = object_of(node);
    if (!object) return object.error();
    page.objects.push_back(std::move(*object));
  }
  const Result<bool> more = is_truncated(root);
  if (!more) return more.error();
  if (*more) page.next = text_of(root, "NextContinuationToken");
  if (*more && page.next.empty()) return not_understood("a list without the token of its next page");
  const Result<S3Time> now = time_of_header(answer.header("date"));
  if (!now) return now.error();
  page.now = *now;
  return page;
}

Result<UploadsPage> uploads_page_of(const net::HttpAnswer& answer) {
  const auto document = parsed_xml(answer.body);
  const pugi::xml_node root = document ? document->child("ListMultipartUploadsResult") : pugi::xml_node();
  if (!root) return not_understood("no list of uploads");
  UploadsPage page;
  for (const pugi::xml_node& node : root.children("Upload")) {
    Result<ListedUpload> upload = upload_of(node);
    if (!upload) return upload.error();
    page.uploads.push_back(std::move(*upload));
  }
  const Result<bool> more = is_truncated(root);
  if (!more) return more.error();
  if (*more) {
    page.next_key = text_of(root, "NextKeyMarker");
    page.next_id = text_of(root, "NextUploadIdMarker");
    if (page.next_key.empty()) return not_understood("a list without the token of its next page");
  }
  const Result<S3Time> now = time_of_header(answer.header("date"));
  if (!now) return now.error();
  page.now = *now;
  return page;
}

Result<std::string> upload_id_of(const net::HttpAnswer& answer) {
  const auto document = parsed_xml(answer.body);
  const std::string id = document ? text_of(document->child("InitiateMultipartUploadResult"), "UploadId") : "";
  if (id.empty()) return not_understood("an upload without an id");
  return id;
}

std::string list_of_parts(const std::vector<std::string>& etags) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("CompleteMultipartUpload");
  unsigned number = 0;
  for (const std::string& etag : etags) {
    pugi::xml_node part = root.append_child("Part");
    part.append_child("PartNumber").text().set(++number);
    part.append_child("ETag").text().set(etag.c_str());
  }
  std::ostringstream text;
  document.save(text, "", pugi::format_raw);
  return text.str();
}

std::string error_code_of(const net::HttpAnswer& answer) {
  if (answer.body.empty()) return "";
  const auto document = parsed_xml(answer.body);
  std::string code = document ? text_of(document->child("Error"), "Code") : "";
  std::erase_if(
      code, [](char c) { return (c < 'a' || c > 'z') && (c < 'A' || c > 'Z') && (c < '0' || c > '9') && c != '.'; });
  return code.substr(0, kMaxCode);
}

}  // namespace meshgauge::server::store
