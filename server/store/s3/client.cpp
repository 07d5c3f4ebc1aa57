#include "server/store/s3/client.h"

#include <curl/curl.h>
#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <optional>
#include <pugixml.hpp>
#include <random>
#include <sstream>
#include <string_view>
#include <thread>

#include "api/base/digest.h"
#include "api/base/text.h"
#include "api/base/utc.h"
#include "server/store/s3/signature.h"

namespace meshgauge::server::store {
namespace {

using net::HttpAnswer;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::size_t kMostText = std::size_t{8} << 20;  // of an answer that is held in memory
constexpr const char* kBytes = "application/octet-stream";

std::string scheme_of(const std::string& endpoint) { return endpoint.substr(0, endpoint.find("://") + 3); }

// The scheme's default port is not in the header Host, and so is not signed.
std::string host_of(const S3Settings& settings) {
  const std::string scheme = scheme_of(settings.endpoint);
  std::string host = settings.endpoint.substr(scheme.size());
  const std::string_view usual = scheme == "https://" ? ":443" : ":80";
  if (host.ends_with(usual)) host.resize(host.size() - usual.size());
  return settings.virtual_host ? settings.bucket + "." + host : host;
}

// Selects the time limits of an exchange.
enum class Pace { small, body, patient };

bool is_good(int status) { return status >= 200 && status < 300; }

bool is_one_of(const std::string& code, std::initializer_list<const char*> codes) {
  return std::any_of(codes.begin(), codes.end(), [&](const char* one) { return code == one; });
}

bool means_no_room(int status, const std::string& code) {
  return status == 507 || is_one_of(code, {"QuotaExceeded", "XMinioStorageFull", "XMinioAdminBucketQuotaExceeded",
                                           "InsufficientStorage", "ServiceQuotaExceeded"});
}

// Differing digests mean damage on the way: the client has checked its own bytes.
bool may_pass(int status, const std::string& code) {
  return status == 429 || status == 408 || (status >= 500 && status != 501 && status != 505 && status != 507) ||
         is_one_of(code, {"RequestTimeout", "SlowDown", "InternalError", "ServiceUnavailable", "OperationAborted",
                          "BadDigest", "IncompleteBody", "XAmzContentSHA256Mismatch", "ConditionalRequestConflict"});
}

// Refusals caused by the configuration: another key or process may be accepted. A refusal without a code is an answer
// to HEAD, or comes from a proxy before S3.
bool is_refusal(int status, const std::string& code) {
  return code.empty() || status == 401 || status == 403 || status == 404 || (status >= 300 && status < 400) ||
         is_one_of(code, {"ExpiredToken", "InvalidToken", "TokenRefreshRequired", "AuthorizationHeaderMalformed"});
}

milliseconds shortened(milliseconds pause) {
  thread_local std::minstd_rand random{std::random_device{}()};
  return pause - milliseconds(std::uniform_int_distribution<milliseconds::rep>(0, pause.count() / 2)(random));
}

net::HttpSettings http_settings(const S3Settings& settings, const S3Limits& limits) {
  net::HttpSettings http;
  http.base = scheme_of(settings.endpoint) + host_of(settings);
  http.ca_file = settings.ca_file;
  http.connect = limits.connect;
  http.stall = limits.stall;
  http.most_body = kMostText;
  return http;
}

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
  std::erase_if(code, [](char c) { return !api::is_letter(c) && !api::is_digit(c) && c != '.'; });
  return code.substr(0, kMaxCode);
}

std::string base64_of_hex(const std::string& hex) {
  std::array<unsigned char, 32> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    bytes[i] = static_cast<unsigned char>(std::stoul(hex.substr(2 * i, 2), nullptr, 16));
  }
  std::array<unsigned char, 48> text{};
  const int size = EVP_EncodeBlock(text.data(), bytes.data(), static_cast<int>(bytes.size()));
  return {reinterpret_cast<const char*>(text.data()), static_cast<std::size_t>(size)};
}

struct S3Client::Call {
  std::string method;
  std::string key;  // empty: the bucket itself
  NamedTexts query = {};
  NamedTexts headers = {};
  std::span<const std::byte> body = {};
  std::string payload_sha256 = kNoBodySha256;
  Pace pace = Pace::small;
  Take take = {};
};

// The result of a call after all its attempts.
struct S3Client::Ending {
  HttpAnswer answer;
  std::string code;    // of a refusal
  bool coded = false;  // whether S3's refusals have a code; those to HEAD have none
  std::uint64_t received = 0;

  bool good() const { return is_good(answer.status) && code.empty(); }
  // A proxy that does not find S3 answers 404 as well: taken for S3's answer, it would fail jobs.
  bool is_not_there() const { return answer.status == 404 && code != "NoSuchBucket" && !(coded && code.empty()); }
  Error error() const;
};

Error S3Client::Ending::error() const {
  if (answer.stopped) return *answer.stopped;
  if (answer.status == 0) return {ErrorCode::storage_unavailable, "S3 cannot be reached", "", ""};
  const std::string what = "S3 answers " + std::to_string(answer.status) + (code.empty() ? "" : " " + code);
  if (means_no_room(answer.status, code)) return {ErrorCode::storage_full, "S3 has no room: " + what, "", ""};
  if (code == "RequestTimeTooSkewed") {
    return {ErrorCode::storage_unavailable, what + ": the clocks of this machine and of S3 differ", "", ""};
  }
  const bool theirs = is_refusal(answer.status, code) || may_pass(answer.status, code);
  return {theirs ? ErrorCode::storage_unavailable : ErrorCode::internal, what, "", ""};
}

S3Client::S3Client(S3Settings settings, S3Limits limits, Report report)
    : settings_(std::move(settings)),
      limits_(limits),
      host_(host_of(settings_)),
      base_path_(settings_.virtual_host ? "/" : "/" + settings_.bucket + "/"),
      http_(http_settings(settings_, limits_)),
      outage_("S3", std::move(report)) {}

HttpAnswer S3Client::attempt(const Call& call, std::uint64_t received, const TakeAnswer& take) {
  std::string path = base_path_ + uri_encoded(call.key, true);
  if (call.key.empty() && path.size() > 1) path.pop_back();
  UnsignedRequest unsigned_request{call.method, host_, path, call.query, call.headers, call.payload_sha256};
  if (received > 0) unsigned_request.headers.emplace_back("range", "bytes=" + std::to_string(received) + "-");
  const std::string query = canonical_query(call.query);

  net::HttpRequest request{call.method, path + (query.empty() ? "" : "?" + query), {}};
  // Signs each attempt: a signature is valid for a quarter of an hour.
  request.headers = signed_headers(unsigned_request, settings_.credentials, settings_.region, amz_date_now());
  request.headers.emplace_back("Expect", "");  // do not wait for "100 Continue", which many servers do not send
  request.body = call.body;
  request.may_stall = call.pace != Pace::body;
  request.limit = call.pace == Pace::body    ? milliseconds(0)
                  : call.pace == Pace::small ? limits_.small
                                             : limits_.patient;
  request.take = take;
  return http_.perform(request);
}

// A caller that stops a body is no sign of an outage.
S3Client::Ending S3Client::perform(const Call& call) {
  Ending ending = perform_patiently(call);
  if (ending.answer.stopped) return ending;
  if (ending.good() || ending.is_not_there()) {
    outage_.over();
  } else {
    const std::string& why = ending.answer.why;
    outage_.failed(ending.error().message + (why.empty() ? "" : ": " + why));
  }
  return ending;
}

S3Client::Ending S3Client::perform_patiently(const Call& call) {
  Ending ending;
  ending.coded = call.method != "HEAD";
  std::uint64_t skip = 0;  // bytes that a server without ranges repeats
  TakeAnswer take;
  if (call.take) {
    take = [&](int status, std::span<const std::byte> piece) -> Result<Done> {
      const std::size_t known = status == 206 ? 0 : std::min<std::uint64_t>(skip, piece.size());
      skip -= known;
      piece = piece.subspan(known);
      ending.received += piece.size();
      return piece.empty() ? Result<Done>(Done{}) : call.take(piece);
    };
  }
  auto begin = steady_clock::now();
  milliseconds pause = limits_.first_pause;
  for (unsigned tries = 1;; ++tries) {
    skip = ending.received;
    ending.answer = attempt(call, ending.received, take);
    ending.code = error_code_of(ending.answer);
    if (ending.received > skip) {  // there is progress: a large object may take its time
      begin = steady_clock::now();
      pause = limits_.first_pause;
      tries = 1;
    }
    const bool again =
        ending.answer.status == 0 ? ending.answer.may_pass() : may_pass(ending.answer.status, ending.code);
    const bool in_time = tries == 1 || steady_clock::now() - begin + pause < limits_.give_up;
    if (!again || tries >= limits_.attempts || !in_time) return ending;
    std::this_thread::sleep_for(shortened(pause));
    pause = std::min(2 * pause, limits_.longest_pause);
  }
}

Result<std::optional<S3Object>> S3Client::head(const std::string& key) {
  const Ending ending = perform({"HEAD", key, {}, {{"x-amz-checksum-mode", "ENABLED"}}});
  if (ending.is_not_there()) return std::optional<S3Object>();
  if (!ending.good()) return ending.error();
  const HttpAnswer& answer = ending.answer;
  const Result<S3Time> modified = time_of_header(answer.header("last-modified"));
  const Result<S3Time> now = time_of_header(answer.header("date"));
  if (!modified) return modified.error();
  if (!now) return now.error();
  S3Object object;
  object.size = std::strtoull(answer.header("content-length").c_str(), nullptr, 10);
  object.sha256 = answer.header("x-amz-checksum-sha256");
  object.etag = answer.header("etag");
  object.age = *now - *modified;
  return std::optional(object);
}

Result<Done> S3Client::put(const std::string& key, std::span<const std::byte> body, const std::string& sha256) {
  Call call{"PUT", key, {}, {{"content-type", kBytes}, {"x-amz-checksum-sha256", base64_of_hex(sha256)}}, body, sha256};
  call.pace = Pace::body;
  const Ending ending = perform(call);
  if (!ending.good()) return ending.error();
  return Done{};
}

Result<bool> S3Client::get(const std::string& key, const Take& take) {
  Call call{"GET", key};
  call.pace = Pace::body;
  call.take = take;
  const Ending ending = perform(call);
  if (ending.answer.status == 416 && ending.received > 0) return true;  // the connection was lost after the last byte
  if (ending.is_not_there() && ending.received == 0) return false;
  if (!ending.good()) return ending.error();
  return true;
}

Result<bool> S3Client::copy_onto_itself(const std::string& key) {
  const std::string source = "/" + settings_.bucket + "/" + uri_encoded(key, true);
  // S3 copies an object onto itself only if something changes: this replaces its metadata by the same.
  Call call{"PUT",
            key,
            {},
            {{"content-type", kBytes}, {"x-amz-copy-source", source}, {"x-amz-metadata-directive", "REPLACE"}}};
  call.pace = Pace::patient;
  const Ending ending = perform(call);
  if (ending.is_not_there()) return false;
  if (!ending.good()) return ending.error();
  return true;
}

Result<Done> S3Client::remove(const std::string& key) {
  const Ending ending = perform({"DELETE", key});
  if (!ending.good() && !ending.is_not_there()) return ending.error();
  return Done{};
}

Result<ListPage> S3Client::list(const std::string& prefix, const std::string& token) {
  Call call{"GET", "", {{"list-type", "2"}, {"prefix", prefix}}};
  if (!token.empty()) call.query.emplace_back("continuation-token", token);
  const Ending ending = perform(call);
  if (!ending.good()) return ending.error();
  Result<ListPage> page = list_page_of(ending.answer);
  if (page && !token.empty() && page->next == token) {
    return Error{ErrorCode::storage_unavailable, "S3 returned the same page of a list twice", "", ""};
  }
  return page;
}

Result<std::string> S3Client::begin_upload(const std::string& key) {
  const Ending ending = perform({"POST", key, {{"uploads", ""}}, {{"content-type", kBytes}}});
  if (!ending.good()) return ending.error();
  return upload_id_of(ending.answer);
}

Result<std::string> S3Client::put_part(const std::string& key, const std::string& upload, unsigned number,
                                       std::span<const std::byte> body, const std::string& sha256) {
  Call call{"PUT", key, {{"partNumber", std::to_string(number)}, {"uploadId", upload}}, {}, body, sha256};
  call.pace = Pace::body;
  const Ending ending = perform(call);
  if (!ending.good()) return ending.error();
  std::string etag = ending.answer.header("etag");
  if (etag.empty()) return Error{ErrorCode::storage_unavailable, "S3 returned no ETag for a part", "", ""};
  return etag;
}

Result<bool> S3Client::complete_upload(const std::string& key, const std::string& upload,
                                       const std::vector<std::string>& etags) {
  const std::string list = list_of_parts(etags);
  const auto body = std::as_bytes(std::span(list));
  Call call{"POST", key, {{"uploadId", upload}}, {{"content-type", "application/xml"}}, body, api::sha256_hex(body)};
  call.pace = Pace::patient;
  const Ending ending = perform(call);
  if (ending.code == "NoSuchUpload") return false;
  if (!ending.good()) return ending.error();
  return true;
}

Result<Done> S3Client::abort_upload(const std::string& key, const std::string& upload) {
  const Ending ending = perform({"DELETE", key, {{"uploadId", upload}}});
  if (!ending.good() && !ending.is_not_there()) return ending.error();
  return Done{};
}

Result<UploadsPage> S3Client::list_uploads(const std::string& prefix, const std::string& after_key,
                                           const std::string& after_id) {
  Call call{"GET", "", {{"uploads", ""}, {"prefix", prefix}}};
  if (!after_key.empty()) call.query.emplace_back("key-marker", after_key);
  if (!after_id.empty()) call.query.emplace_back("upload-id-marker", after_id);
  const Ending ending = perform(call);
  if (ending.answer.status == 501) return UploadsPage{};  // the server has no such lists
  if (!ending.good()) return ending.error();
  return uploads_page_of(ending.answer);
}

}  // namespace meshgauge::server::store
