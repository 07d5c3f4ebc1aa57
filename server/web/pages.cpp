#include "server/web/pages.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <map>
#include <mutex>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "api/base/digest.h"
#include "engine/hausdorff.h"
#include "server/http/head_values.h"
#include "server/web/embedded.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

// The policies allow no inline script or style, no other origin and no framing. swagger-ui has pictures in its style
// sheet, and makes markup from strings, which trusted types forbid on the other page.
constexpr std::string_view kReferencePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
constexpr std::string_view kPagePolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'; require-trusted-types-for 'script'; "
    "trusted-types 'none'";

constexpr const char* kAskAgain = "no-cache";                            // revalidated by its ETag each time
constexpr const char* kForEver = "public, max-age=31536000, immutable";  // for names with a digest of the content
constexpr const char* kForAnHour = "public, max-age=3600";

constexpr std::array<std::pair<std::string_view, const char*>, 5> kTypes{{{".html", "text/html; charset=utf-8"},
                                                                          {".js", "text/javascript; charset=utf-8"},
                                                                          {".css", "text/css; charset=utf-8"},
                                                                          {".svg", "image/svg+xml"},
                                                                          {".png", "image/png"}}};

const char* type_of(std::string_view name) {
  const auto* const found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) { return name.ends_with(type.first); });
  return found == kTypes.end() ? "text/plain; charset=utf-8" : found->second;
}

struct File {
  std::string_view name;
  std::string_view gzip;
  std::string digest;
};

const std::map<std::string_view, File>& files() {
  static const std::map<std::string_view, File> all = [] {
    std::map<std::string_view, File> made;
    for (const Asset& asset : assets()) {
      const auto bytes = std::as_bytes(std::span(asset.gzip));
      made.emplace(asset.name, File{asset.name, asset.gzip, api::sha256_hex(bytes).substr(0, 32)});
    }
    return made;
  }();
  return all;
}

const File* find(std::string_view name) {
  const auto found = files().find(name);
  return found == files().end() ? nullptr : &found->second;
}

// Decompresses an embedded file. Its last four bytes give the length; a mismatch is a broken build.
std::string expanded(std::string_view gzip) {
  std::uint32_t length = 0;  // the last four bytes, the lowest first
  for (std::size_t i = 1; i <= 4; ++i) length = length << 8 | static_cast<unsigned char>(gzip[gzip.size() - i]);
  std::string text(length, '\0');
  z_stream stream{};
  if (inflateInit2(&stream, 15 + 16) != Z_OK) throw std::runtime_error("zlib does not start");
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(gzip.data()));
  stream.avail_in = static_cast<uInt>(gzip.size());
  stream.next_out = reinterpret_cast<Bytef*>(text.data());
  stream.avail_out = length;
  const int end = inflate(&stream, Z_FINISH);
  inflateEnd(&stream);
  if (end != Z_STREAM_END) throw std::runtime_error("a file of the page is damaged");
  return text;
}

// Decompressed at its first use: a client that takes no gzip must not cost that each time.
std::string_view plain_text_of(const File& file) {
  static std::mutex mutex;
  static std::map<std::string_view, std::string> texts;
  const std::lock_guard lock(mutex);
  auto found = texts.find(file.name);
  if (found == texts.end()) found = texts.emplace(file.name, expanded(file.gzip)).first;
  return found->second;
}

bool reads_gzip(const Head& head) { return weight_of(head.header("accept-encoding"), "gzip") > 0; }

// Without a copy, which clients that do not read would keep, each its own.
void put(Response& response, const File& file, bool compressed) {
  response.content_type = type_of(file.name);
  if (compressed) response.headers.emplace_back("Content-Encoding", "gzip");
  response.file = FileBody{std::as_bytes(std::span(compressed ? file.gzip : plain_text_of(file))), nullptr};
}

void send(Exchange& exchange, const File& file, const char* keep) {
  Response& response = exchange.response;
  const bool compressed = reads_gzip(exchange.head);
  const std::string tag = '"' + file.digest + (compressed ? "-gzip\"" : "\"");
  response.headers.emplace_back("Cache-Control", keep);
  response.headers.emplace_back("ETag", tag);
  add_vary(response, "Accept-Encoding");
  const std::string_view known = exchange.head.header("if-none-match");
  if (known.find(tag) != std::string_view::npos) {
    response.status = kNotModified;
    return;
  }
  put(response, file, compressed);
}

void show(Exchange& exchange, const char* name, std::string_view policy) {
  const File* page = find(name);
  if (!page) {
    const Problem without{ProblemKind::not_found,
                          "this service was built without its pages, which needs npm; /openapi.yaml describes the API",
                          {}};
    return answer(exchange, without);
  }
  exchange.response.headers.emplace_back("Content-Security-Policy", policy);
  send(exchange, *page, kAskAgain);
}

// True for browsers. Clients without Accept, or that accept anything, get a problem.
bool prefers_a_page(const Head& head) {
  const std::string_view accept = head.header("accept");
  const double problem = std::max(weight_of(accept, "application/problem+json"), weight_of(accept, "application/json"));
  return weight_of(accept, "text/html") > problem;
}

bool is_id(std::string_view text) {
  return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

// True for names that the bundler made: they end in a digest of eight characters of base 32.
bool is_named_by_digest(std::string_view name) {
  const std::string_view stem = name.substr(0, name.rfind('.'));
  const auto dash = stem.rfind('-');
  return dash != std::string_view::npos && stem.size() - dash - 1 == 8 &&
         stem.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ234567", dash + 1) == std::string_view::npos;
}

}  // namespace

bool has_pages() { return !assets().empty(); }

void send_description(Exchange& exchange) {
  exchange.response.content_type = "application/yaml";
  exchange.response.file = FileBody{std::as_bytes(std::span(openapi_yaml())), nullptr};
}

void send_gates_schema(Exchange& exchange) {
  exchange.response.content_type = "application/schema+json";
  exchange.response.file = FileBody{std::as_bytes(std::span(gates_schema())), nullptr};
}

void show_root(Exchange& exchange) {
  const std::string_view accept = exchange.head.header("accept");
  const bool text = weight_of(accept, "text/plain") > weight_of(accept, "text/html");
  add_vary(exchange.response, "Accept");
  if (has_pages() && !text) return show(exchange, "page/index.html", kPagePolicy);
  exchange.response.content_type = "text/plain";
  exchange.response.body = std::string("meshgauge ") + version() +
                           "\nPOST /v1/comparisons compares two meshes; see /docs and /openapi.yaml\n";
}

void show_permanent_link(Exchange& exchange) {
  if (is_id(exchange.segment)) return show(exchange, "page/index.html", kPagePolicy);
  show_damaged_link(exchange);
}

void show_damaged_link(Exchange& exchange) {
  answer(exchange, Problem{ProblemKind::not_found, "the link is damaged: its id must be 32 lower-case hex digits", {}});
  Response& response = exchange.response;
  add_vary(response, "Accept");
  const File* page = find("page/index.html");
  if (!page || !prefers_a_page(exchange.head)) return;
  add_vary(response, "Accept-Encoding");
  response.headers.emplace_back("Content-Security-Policy", kPagePolicy);
  put(response, *page, reads_gzip(exchange.head));
}

void send_page_file(Exchange& exchange) {
  const File* file = exchange.segment == "index.html" ? nullptr : find("page/" + exchange.segment);
  if (!file) return answer(exchange, Problem{ProblemKind::not_found, "the page has no such file", {}});
  send(exchange, *file, is_named_by_digest(file->name) ? kForEver : kForAnHour);
}

void show_reference(Exchange& exchange) { show(exchange, "docs/docs.html", kReferencePolicy); }

void send_reference_file(Exchange& exchange) {
  const File* file = exchange.segment == "docs.html" ? nullptr : find("docs/" + exchange.segment);
  if (!file) return answer(exchange, Problem{ProblemKind::not_found, "the page /docs has no such file", {}});
  send(exchange, *file, kForAnHour);
}

}  // namespace meshgauge::server
