#include "net/http_client.h"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <system_error>

#include <curl/curl.h>

namespace meshgauge::net {
namespace {

constexpr std::size_t kMaxIdle = 64;
constexpr long kIdleSeconds = 60;  // servers close connections that are idle for longer
constexpr int kTickMs = 10;
constexpr std::uint64_t kWorthLeave = 1U << 20U;  // bytes from which a body waits for 100 Continue

// Files of certificates.
constexpr const char* kPlaces[] = {
    "/etc/ssl/certs/ca-certificates.crt",  // Debian, Ubuntu, Arch, Alpine
    "/etc/pki/tls/certs/ca-bundle.crt",    // Fedora, Red Hat
    "/etc/ssl/ca-bundle.pem",              // openSUSE
    "/etc/ssl/cert.pem",                   // others
};

void start_library() {
  static const bool started = [] {
    std::signal(SIGPIPE, SIG_IGN);  // CURLOPT_NOSIGNAL requires it: TLS may write to a closed connection
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) throw std::runtime_error("libcurl does not start");
    return true;
  }();
  static_cast<void>(started);
}

Trouble trouble_of(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
    case CURLE_COULDNT_CONNECT:
      return Trouble::no_contact;
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_GOT_NOTHING:
    case CURLE_PARTIAL_FILE:
    case CURLE_SSL_CONNECT_ERROR:  // also a connection lost during the handshake
    case CURLE_PROXY:
      return Trouble::broken;
    default:
      return Trouble::hopeless;
  }
}

struct Freed {
  void operator()(CURL* easy) const { curl_easy_cleanup(easy); }
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};
struct Ended {
  void operator()(CURLM* multi) const { curl_multi_cleanup(multi); }
};

// State of a transfer for libcurl's callbacks.
struct Transfer {
  CURL* easy;
  const HttpRequest& request;
  const std::size_t most_body;
  HttpAnswer answer = {};
  std::size_t sent = 0;

  int status() const {
    long code = 0;
    curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &code);
    return static_cast<int>(code);
  }
};

std::size_t send_more(char* buffer, std::size_t size, std::size_t count, void* context) {
  auto& transfer = *static_cast<Transfer*>(context);
  const auto rest = transfer.request.body.subspan(transfer.sent);
  const auto piece = rest.first(std::min(rest.size(), size * count));
  std::copy(piece.begin(), piece.end(), reinterpret_cast<std::byte*>(buffer));
  transfer.sent += piece.size();
  return piece.size();
}

// Rewinds the body: libcurl replaces a connection that was closed meanwhile and sends again.
int send_again(void* context, curl_off_t offset, int origin) {
  auto& transfer = *static_cast<Transfer*>(context);
  if (origin != SEEK_SET || offset < 0 || static_cast<std::uint64_t>(offset) > transfer.request.body.size())
    return CURL_SEEKFUNC_CANTSEEK;
  transfer.sent = static_cast<std::size_t>(offset);
  return CURL_SEEKFUNC_OK;
}

// Returning another number than `size` ends the transfer.
std::size_t receive(char* data, std::size_t size, std::size_t count, void* context) {
  auto& transfer = *static_cast<Transfer*>(context);
  const std::size_t all = size * count;
  const int status = transfer.status();
  if (transfer.request.take && (status == 200 || status == 206)) {
    const auto taken = transfer.request.take(status, {reinterpret_cast<const std::byte*>(data), all});
    if (taken) return all;
    transfer.answer.stopped = taken.error();
    return all + 1;
  }
  std::string& body = transfer.answer.body;
  if (all > transfer.most_body - body.size()) return all + 1;
  body.append(data, all);
  return all;
}

using Headers = std::unique_ptr<curl_slist, Freed>;

Headers headers_of(const HttpRequest& request) {
  Headers list;
  const auto append = [&](const std::string& line) {
    curl_slist* longer = curl_slist_append(list.get(), line.c_str());
    if (!longer) throw std::bad_alloc();
    (void)list.release();  // the pointer has not changed
    list.reset(longer);
  };
  for (const auto& [name, value] : request.headers) append(value.empty() ? name + ":" : name + ": " + value);
  if (request.body.size() < kWorthLeave) append("Expect:");
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

void set_callbacks(CURL* easy, Transfer& transfer) {
  curl_easy_setopt(easy, CURLOPT_READFUNCTION, send_more);
  curl_easy_setopt(easy, CURLOPT_READDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_SEEKFUNCTION, send_again);
  curl_easy_setopt(easy, CURLOPT_SEEKDATA, &transfer);
  curl_easy_setopt(easy, CURLOPT_WRITEFUNCTION, receive);
  curl_easy_setopt(easy, CURLOPT_WRITEDATA, &transfer);
}

void set_limits(CURL* easy, const HttpSettings& settings, const HttpRequest& request) {
  if (!request.take && request.method != "HEAD") {  // the answer to a HEAD has the length of another one's body
    curl_easy_setopt(easy, CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(settings.most_body));
  }
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(settings.connect.count()));
  curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(request.limit.count()));
  if (request.may_stall) return;
  const auto stall = request.stall.count() > 0 ? std::min(request.stall, settings.stall) : settings.stall;
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, settings.least_speed);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, static_cast<long>(stall.count()));
}

void set_access(CURL* easy, const HttpSettings& settings) {
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);
  if (!settings.user_agent.empty()) curl_easy_setopt(easy, CURLOPT_USERAGENT, settings.user_agent.c_str());
  if (settings.without_proxy) curl_easy_setopt(easy, CURLOPT_NOPROXY, "*");
  if (!settings.ca_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_CAINFO, settings.ca_file.c_str());
    curl_easy_setopt(easy, CURLOPT_CAPATH, nullptr);  // this machine's certificates would be trusted as well
  } else if (const std::string file = machine_certificates(); !file.empty()) {
    curl_easy_setopt(easy, CURLOPT_CAINFO, file.c_str());
  }
  if (settings.key.empty()) return;
  curl_easy_setopt(easy, CURLOPT_HTTPAUTH, CURLAUTH_BEARER);
  curl_easy_setopt(easy, CURLOPT_XOAUTH2_BEARER, settings.key.c_str());
}

void set_connection(CURL* easy) {
  curl_easy_setopt(easy, CURLOPT_PATH_AS_IS, 1L);  // the path must be sent as it was signed
  curl_easy_setopt(easy, CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);  // an interruption does not wait for a DNS lookup
  curl_easy_setopt(easy, CURLOPT_MAXAGE_CONN, kIdleSeconds);
  curl_easy_setopt(easy, CURLOPT_UPLOAD_BUFFERSIZE, 1L << 20);
  curl_easy_setopt(easy, CURLOPT_BUFFERSIZE, 256L << 10);
}

// nullopt: interrupted.
std::optional<CURLcode> drive(CURLM* multi, const Interrupted& interrupted) {
  for (int running = 1;;) {
    if (curl_multi_perform(multi, &running) != CURLM_OK) return CURLE_FAILED_INIT;
    if (running == 0) break;
    if (interrupted()) return std::nullopt;
    curl_multi_poll(multi, nullptr, 0, kTickMs, nullptr);
  }
  int left = 0;
  while (const CURLMsg* message = curl_multi_info_read(multi, &left)) {
    if (message->msg == CURLMSG_DONE) return message->data.result;
  }
  return CURLE_FAILED_INIT;
}

void read_head(CURL* easy, HttpAnswer& answer) {
  for (curl_header* header = nullptr; (header = curl_easy_nextheader(easy, CURLH_HEADER, -1, header)) != nullptr;) {
    std::string name = header->name;
    for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    answer.headers[name] = header->value;
  }
  curl_off_t after = 0;
  const char* redirect = nullptr;
  curl_easy_getinfo(easy, CURLINFO_RETRY_AFTER, &after);
  curl_easy_getinfo(easy, CURLINFO_REDIRECT_URL, &redirect);
  if (after > 0) answer.retry_after = std::chrono::seconds(after);
  if (redirect) answer.redirect = redirect;
}

// Stores the failure of a transfer, if any, in its answer.
void conclude(Transfer& transfer, std::optional<CURLcode> code, const HttpSettings& settings, const char* text) {
  HttpAnswer& answer = transfer.answer;
  const int status = transfer.status();
  const bool cut = code && (*code == CURLE_SEND_ERROR || *code == CURLE_RECV_ERROR);
  const bool early = settings.early_refusals && status >= 400 && cut;
  if (code == CURLE_OK || early) {
    answer.status = status;
    return read_head(transfer.easy, answer);
  }
  curl_off_t connected = 0;
  curl_easy_getinfo(transfer.easy, CURLINFO_CONNECT_TIME_T, &connected);
  if (!code) {
    answer.trouble = Trouble::cancelled;
    answer.why = "cancelled";
  } else if (answer.stopped) {
    answer.trouble = Trouble::hopeless;
    answer.why = answer.stopped->message;
  } else if (code == CURLE_WRITE_ERROR || code == CURLE_FILESIZE_EXCEEDED) {
    answer.trouble = Trouble::hopeless;
    answer.why = "its answer is larger than " + std::to_string(settings.most_body) + " bytes";
  } else {
    answer.trouble = *code == CURLE_OPERATION_TIMEDOUT && connected == 0 ? Trouble::no_contact : trouble_of(*code);
    answer.why = *text != '\0' ? text : curl_easy_strerror(*code);
  }
}

}  // namespace

std::string machine_certificates() {
  const char* named = std::getenv("SSL_CERT_FILE");
  if (named && *named != '\0') return named;
  for (const char* place : kPlaces) {
    std::error_code ignored;
    if (std::filesystem::exists(place, ignored)) return place;
  }
  return "";
}

std::string HttpAnswer::header(const std::string& name) const {
  const auto found = headers.find(name);
  return found == headers.end() ? "" : found->second;
}

// The multi handle owns the kept connection, so it must outlive the easy handle.
struct HttpClient::Connection {
  std::unique_ptr<CURLM, Ended> multi{curl_multi_init()};
  std::unique_ptr<CURL, Freed> easy{curl_easy_init()};
};

HttpClient::HttpClient(HttpSettings settings) : settings_(std::move(settings)) { start_library(); }

HttpClient::~HttpClient() = default;

std::unique_ptr<HttpClient::Connection> HttpClient::take_idle() {
  {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
      auto connection = std::move(idle_.back());  // newest first: the server may close the others
      idle_.pop_back();
      return connection;
    }
  }
  auto connection = std::make_unique<Connection>();
  if (!connection->multi || !connection->easy) throw std::bad_alloc();
  return connection;
}

void HttpClient::give_back(std::unique_ptr<Connection> connection) {
  const std::lock_guard lock(mutex_);
  if (idle_.size() < kMaxIdle) idle_.push_back(std::move(connection));
}

HttpAnswer HttpClient::perform(const HttpRequest& request, const Interrupted& interrupted) {
  if (request.begin) request.begin();
  auto connection = take_idle();
  CURL* easy = connection->easy.get();
  Transfer transfer{easy, request, settings_.most_body};
  char text[CURL_ERROR_SIZE] = {};
  const std::string url = settings_.base + request.path;
  const Headers headers = headers_of(request);
  curl_easy_reset(easy);
  curl_easy_setopt(easy, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, text);
  set_connection(easy);
  set_access(easy, settings_);
  set_limits(easy, settings_, request);
  set_method(easy, request);
  set_callbacks(easy, transfer);

  CURLM* multi = connection->multi.get();
  if (curl_multi_add_handle(multi, easy) != CURLM_OK) throw std::runtime_error("libcurl takes no handle");
  const auto code = drive(multi, interrupted);
  curl_multi_remove_handle(multi, easy);
  conclude(transfer, code, settings_, text);
  // libcurl closes connections that did not end well.
  curl_easy_reset(easy);
  give_back(std::move(connection));
  return std::move(transfer.answer);
}

}  // namespace meshgauge::net
