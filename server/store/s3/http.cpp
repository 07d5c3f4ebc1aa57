#include "server/store/s3/http.h"

#include <curl/curl.h>

#include <algorithm>
#include <cctype>
#include <csignal>
#include <stdexcept>
#include <string_view>

namespace meshgauge::server::store {
namespace {

constexpr std::size_t kMaxIdle = 32;
constexpr long kIdleSeconds = 60;  // servers close what is idle for longer

void start_library() {
  static const bool started = [] {
    std::signal(SIGPIPE, SIG_IGN);  // CURLOPT_NOSIGNAL leaves that to us; TLS may write to a peer that has gone
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) throw std::runtime_error("libcurl does not start");
    return true;
  }();
  static_cast<void>(started);
}

// What may be different at the next attempt.
bool may_pass(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
    case CURLE_COULDNT_CONNECT:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_GOT_NOTHING:
    case CURLE_PARTIAL_FILE:
    case CURLE_SSL_CONNECT_ERROR:  // also of a connection that is lost in the handshake
    case CURLE_PROXY:
      return true;
    default:
      return false;
  }
}

// An exchange as libcurl's callbacks see it.
struct Exchange {
  CURL* easy;
  const HttpRequest& request;
  HttpAnswer answer;
  std::uint64_t sent = 0;
  bool too_long = false;

  long status() const {
    long code = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &code);
    return code;
  }
};

std::size_t send_more(char* buffer, std::size_t size, std::size_t count, void* context) {
  auto& exchange = *static_cast<Exchange*>(context);
  const std::span into(reinterpret_cast<std::byte*>(buffer), size * count);
  Result<std::size_t> read = exchange.request.body.read(exchange.sent, into);
  if (!read) {
    exchange.answer.stopped = read.error();
    return CURL_READFUNC_ABORT;
  }
  exchange.sent += *read;
  return *read;
}

// A connection that was closed meanwhile is replaced by libcurl, and what was sent over it is sent again.
int send_again(void* context, curl_off_t offset, int origin) {
  if (origin != SEEK_SET || offset < 0) return CURL_SEEKFUNC_CANTSEEK;
  static_cast<Exchange*>(context)->sent = static_cast<std::uint64_t>(offset);
  return CURL_SEEKFUNC_OK;
}

// Another number than `size` ends the exchange.
std::size_t receive(char* data, std::size_t size, std::size_t count, void* context) {
  auto& exchange = *static_cast<Exchange*>(context);
  const std::size_t all = size * count;
  const long status = exchange.status();
  if (exchange.request.take && (status == 200 || status == 206)) {
    Result<Done> taken = exchange.request.take(status, {reinterpret_cast<const std::byte*>(data), all});
    if (taken) return all;
    exchange.answer.stopped = taken.error();
    return 0;
  }
  exchange.too_long = exchange.answer.text.size() + all > HttpAnswer::kMaxText;
  if (exchange.too_long) return 0;
  exchange.answer.text.append(data, all);
  return all;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.remove_suffix(1);
  return text;
}

std::size_t receive_header(char* data, std::size_t size, std::size_t count, void* context) {
  auto& headers = static_cast<Exchange*>(context)->answer.headers;
  const std::string_view line(data, size * count);
  const std::size_t colon = line.find(':');
  if (line.starts_with("HTTP/")) headers.clear();  // of an interim answer
  if (colon == std::string_view::npos || line.starts_with("HTTP/")) return line.size();
  std::string name(line.substr(0, colon));
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  headers[name] = trimmed(line.substr(colon + 1));
  return line.size();
}

struct FreedList {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
using HeaderList = std::unique_ptr<curl_slist, FreedList>;

void append(HeaderList& list, const std::string& line) {
  curl_slist* longer = curl_slist_append(list.get(), line.c_str());
  if (longer == nullptr) throw std::bad_alloc();
  static_cast<void>(list.release());
  list.reset(longer);
}

HeaderList header_list(const HttpRequest& request) {
  HeaderList list;
  for (const auto& [name, value] : request.headers) append(list, name + ": " + value);
  append(list, "Expect:");  // not to wait for a leave to send that many servers do not give
  return list;
}

void set_method(CURL* easy, const HttpRequest& request) {
  if (request.method == "HEAD") {
    curl_easy_setopt(easy, CURLOPT_NOBODY, 1L);
  } else if (request.method == "PUT" || request.method == "POST") {
    curl_easy_setopt(easy, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(easy, CURLOPT_INFILESIZE_LARGE, static_cast<curl_off_t>(request.body.size()));
  }
  if (request.method == "POST" || request.method == "DELETE") {
    curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, request.method.c_str());
  }
}

void set_callbacks(CURL* easy, Exchange& exchange) {
  curl_easy_setopt(easy, CURLOPT_READFUNCTION, send_more);
  curl_easy_setopt(easy, CURLOPT_READDATA, &exchange);
  curl_easy_setopt(easy, CURLOPT_SEEKFUNCTION, send_again);
  curl_easy_setopt(easy, CURLOPT_SEEKDATA, &exchange);
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, receive);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &exchange);
  curl_easy_setopt(easy, CURLOPT_HEADERFUNCTION, receive_header);
  curl_easy_setopt(easy, CURLOPT_HEADERDATA, &exchange);
}

}  // namespace

std::string HttpAnswer::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

void HttpConnections::Freed::operator()(void* easy) const { curl_easy_cleanup(easy); }

HttpConnections::HttpConnections(std::string ca_file, HttpLimits limits)
    : ca_file_(std::move(ca_file)), limits_(limits) {
  start_library();
}

HttpConnections::~HttpConnections() = default;

HttpConnections::Easy HttpConnections::take_idle() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      Easy easy = std::move(idle_.back());  // the newest: the others may be closed by the server in peace
      idle_.pop_back();
      return easy;
    }
  }
  Easy easy(curl_easy_init());
  if (!easy) throw std::bad_alloc();
  return easy;
}

void HttpConnections::give_back(Easy easy) {
  const std::lock_guard lock(mutex_);
  if (idle_.size() < kMaxIdle) idle_.push_back(std::move(easy));
}

void HttpConnections::prepare(void* easy, const HttpRequest& request) const {
  curl_easy_reset(easy);
  curl_easy_setopt(easy, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(easy, CURLOPT_PATH_AS_IS, 1L);  // what is signed is what is sent
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_MAXAGE_CONN, kIdleSeconds);
  curl_easy_setopt(easy, CURLOPT_UPLOAD_BUFFERSIZE, 1L << 20);
  curl_easy_setopt(easy, CURLOPT_BUFFERSIZE, 256L << 10);
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(limits_.connect.count()));
  if (request.pace == HttpPace::body) {
    curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, 1L);
    curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, static_cast<long>(limits_.stall.count()));
  } else {
    const auto limit = request.pace == HttpPace::small ? limits_.small : limits_.patient;
    curl_easy_setopt(easy, CURLOPT_TIMEOUT, static_cast<long>(limit.count()));
  }
  if (!ca_file_.empty()) curl_easy_setopt(easy, CURLOPT_CAINFO, ca_file_.c_str());
  set_method(easy, request);
}

HttpAnswer HttpConnections::perform(const HttpRequest& request) {
  Easy easy = take_idle();
  Exchange exchange{easy.get(), request, {}};
  prepare(easy.get(), request);
  set_callbacks(easy.get(), exchange);
  const HeaderList headers = header_list(request);
  curl_easy_setopt(easy.get(), CURLOPT_HTTPHEADER, headers.get());

  const CURLcode code = curl_easy_perform(easy.get());
  HttpAnswer& answer = exchange.answer;
  if (code == CURLE_OK) {
    answer.status = exchange.status();
  } else if (!answer.stopped) {
    answer.may_pass = may_pass(code) && !exchange.too_long;
    answer.trouble = exchange.too_long ? "the answer is too long" : curl_easy_strerror(code);
  }
  // Only a connection on which all went well is worth keeping; libcurl itself closes the others.
  curl_easy_reset(easy.get());
  give_back(std::move(easy));
  return std::move(answer);
}

}  // namespace meshgauge::server::store
