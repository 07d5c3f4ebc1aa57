#include "check/remote/connection.h"

#include <csignal>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "check/remote/address.h"
#include "engine/hausdorff.h"

namespace meshgauge::check::service {
namespace {

constexpr int kTickMs = 10;
constexpr long kHardlyMoves = 1000;  // bytes a second

void start_library() {
  static std::once_flag once;
  std::call_once(once, [] {
    std::signal(SIGPIPE, SIG_IGN);  // CURLOPT_NOSIGNAL leaves that to us; TLS may write to a peer that has gone
    if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) throw std::runtime_error("libcurl does not start");
  });
}

// Where an answer goes to.
struct Target {
  CURL* easy;
  Sink* sink;  // of a success; may be null
  Reply reply;
  bool refused = false;  // by the sink
};

// libcurl's callback: another number than `size` ends the exchange.
std::size_t keep(const char* data, std::size_t /*one*/, std::size_t size, void* to) {
  auto& target = *static_cast<Target*>(to);
  long status = 0;
  curl_easy_getinfo(target.easy, CURLINFO_RESPONSE_CODE, &status);
  if (target.sink && status == 200) {
    target.refused = !target.sink->take({data, size});
    return target.refused ? size + 1 : size;
  }
  std::string& body = target.reply.body;
  if (size > kMostReplyBytes - body.size()) return size + 1;
  body.append(data, size);
  return size;
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
    case CURLE_SSL_CONNECT_ERROR:  // also of a connection that is lost in the handshake
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
    case CURLE_PROXY:
      return Trouble::broken;
    default:
      return Trouble::hopeless;
  }
}

}  // namespace

Connection::Connection(const Access& access)
    : access_(access), multi_((start_library(), curl_multi_init())), easy_(curl_easy_init()) {
  if (!multi_ || !easy_) throw std::runtime_error("libcurl gives no handle");
}

Exchange Connection::send(const Call& call, const Interrupted& interrupted) {
  Target target{easy_.get(), call.sink, {}};
  if (call.sink) call.sink->begin();
  Headers headers;
  for (const std::string& header : call.headers) {
    curl_slist* longer = curl_slist_append(headers.get(), header.c_str());
    if (!longer) throw std::bad_alloc();
    (void)headers.release();  // the same list
    headers.reset(longer);
  }
  set(call, headers);
  curl_easy_setopt(easy_.get(), CURLOPT_WRITEFUNCTION, &keep);
  curl_easy_setopt(easy_.get(), CURLOPT_WRITEDATA, &target);
  if (curl_multi_add_handle(multi_.get(), easy_.get()) != CURLM_OK) throw std::runtime_error("libcurl takes no handle");
  const auto code = drive(interrupted);
  curl_multi_remove_handle(multi_.get(), easy_.get());
  if (!code) return {Trouble::cancelled, "cancelled", {}};
  if (target.refused) return {Trouble::hopeless, "its answer is not what was asked for", {}};
  return concluded(*code, std::move(target.reply));
}

void Connection::set(const Call& call, const Headers& headers) {
  CURL* easy = easy_.get();
  curl_easy_reset(easy);
  text_[0] = '\0';
  const std::string url = access_.base + call.path;
  curl_easy_setopt(easy, CURLOPT_URL, url.c_str());
  curl_easy_setopt(easy, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(easy, CURLOPT_FOLLOWLOCATION, 0L);  // a key goes to the address that was given, and nowhere else
  curl_easy_setopt(easy, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(easy, CURLOPT_QUICK_EXIT, 1L);  // a name that is being looked up does not hold up who gives up
  curl_easy_setopt(easy, CURLOPT_ERRORBUFFER, text_);
  curl_easy_setopt(easy, CURLOPT_USERAGENT, (std::string("meshgauge/") + version()).c_str());
  curl_easy_setopt(easy, CURLOPT_HTTPHEADER, headers.get());
  curl_easy_setopt(easy, CURLOPT_TIMEOUT_MS, static_cast<long>(call.limit.count()));
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_LIMIT, kHardlyMoves);
  curl_easy_setopt(easy, CURLOPT_LOW_SPEED_TIME, static_cast<long>(access_.stall.count()));
  set_body(call);
  set_access();
}

void Connection::set_body(const Call& call) {
  CURL* easy = easy_.get();
  if (call.method == "HEAD") curl_easy_setopt(easy, CURLOPT_NOBODY, 1L);
  if (call.method == "PUT" || call.method == "POST") {
    curl_easy_setopt(easy, CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(call.body.size()));
    curl_easy_setopt(easy, CURLOPT_POSTFIELDS, reinterpret_cast<const char*>(call.body.data()));  // not copied
  }
  if (call.method == "PUT" || call.method == "DELETE") {
    curl_easy_setopt(easy, CURLOPT_CUSTOMREQUEST, call.method.c_str());
  }
}

void Connection::set_access() {
  CURL* easy = easy_.get();
  curl_easy_setopt(easy, CURLOPT_CONNECTTIMEOUT_MS, static_cast<long>(access_.connect_timeout.count()));
  if (access_.without_proxy) curl_easy_setopt(easy, CURLOPT_NOPROXY, "*");
  if (!access_.ca_file.empty()) {
    curl_easy_setopt(easy, CURLOPT_CAINFO, access_.ca_file.c_str());
    curl_easy_setopt(easy, CURLOPT_CAPATH, nullptr);  // this machine's, which would be trusted as well
  }
  if (access_.key.empty()) return;
  curl_easy_setopt(easy, CURLOPT_HTTPAUTH, CURLAUTH_BEARER);
  curl_easy_setopt(easy, CURLOPT_XOAUTH2_BEARER, access_.key.c_str());
}

// nullopt: interrupted.
std::optional<CURLcode> Connection::drive(const Interrupted& interrupted) {
  for (int running = 1;;) {
    if (curl_multi_perform(multi_.get(), &running) != CURLM_OK) return CURLE_FAILED_INIT;
    if (running == 0) break;
    if (interrupted()) return std::nullopt;
    curl_multi_poll(multi_.get(), nullptr, 0, kTickMs, nullptr);
  }
  int left = 0;
  while (const CURLMsg* message = curl_multi_info_read(multi_.get(), &left)) {
    if (message->msg == CURLMSG_DONE) return message->data.result;
  }
  return CURLE_FAILED_INIT;
}

Exchange Connection::concluded(CURLcode code, Reply reply) {
  CURL* easy = easy_.get();
  long status = 0;
  curl_easy_getinfo(easy, CURLINFO_RESPONSE_CODE, &status);
  reply.status = static_cast<int>(status);
  // A service that refuses a body may close before all of it is sent: its answer counts.
  const bool refused = status >= 400 && (code == CURLE_SEND_ERROR || code == CURLE_RECV_ERROR);
  if (code != CURLE_OK && !refused) {
    const bool waited = code == CURLE_OPERATION_TIMEDOUT;
    curl_off_t connected = 0;
    curl_easy_getinfo(easy, CURLINFO_CONNECT_TIME_T, &connected);
    return {waited && connected == 0 ? Trouble::no_contact : trouble_of(code), why(code), {}};
  }
  curl_off_t after = 0;
  const char *type = nullptr, *redirect = nullptr;
  curl_easy_getinfo(easy, CURLINFO_RETRY_AFTER, &after);
  curl_easy_getinfo(easy, CURLINFO_CONTENT_TYPE, &type);
  curl_easy_getinfo(easy, CURLINFO_REDIRECT_URL, &redirect);
  if (after > 0) reply.retry_after = std::chrono::seconds(after);
  if (type) reply.content_type = type;
  if (redirect) reply.redirect = redirect;
  return {Trouble::none, "", std::move(reply)};
}

std::string Connection::why(CURLcode code) const {
  if (code == CURLE_WRITE_ERROR) return "its answer is larger than " + std::to_string(kMostReplyBytes) + " bytes";
  const std::string text = one_line(text_[0] ? text_ : curl_easy_strerror(code));
  return code == CURLE_SSL_CACERT_BADFILE ? text + " (--ca-file)" : text;
}

}  // namespace meshgauge::check::service
