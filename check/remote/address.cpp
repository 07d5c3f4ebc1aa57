#include "check/remote/address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <memory>

#include <curl/curl.h>

#include "api/base/refused.h"
#include "api/base/text.h"
#include "api/base/utf8.h"
#include "check/text.h"

namespace meshgauge::check::service {
namespace {

constexpr std::size_t kMostNameBytes = 200;

struct Freed {
  void operator()(CURLU* url) const { curl_url_cleanup(url); }
  void operator()(char* text) const { curl_free(text); }
};

Error bad_server(const std::string& why) { return bad_flag("--server", why); }

bool has(CURLU* url, CURLUPart part) {
  char* text = nullptr;
  const bool found = curl_url_get(url, part, &text, 0) == CURLUE_OK;
  curl_free(text);
  return found;
}

using Url = std::unique_ptr<CURLU, Freed>;

// Returns the host in lower case, IPv6 addresses in brackets; empty: not an address.
std::string host_of(const std::string& base) {
  const Url parsed(curl_url());
  char* text = nullptr;
  const bool found = parsed && curl_url_set(parsed.get(), CURLUPART_URL, base.c_str(), 0) == CURLUE_OK &&
                     curl_url_get(parsed.get(), CURLUPART_HOST, &text, 0) == CURLUE_OK;
  return found ? api::lower_case(std::unique_ptr<char, Freed>(text).get()) : "";
}

// Whether the host is an address in 127.0.0.0/8. A host name may begin with 127 as well.
bool is_ipv4_loopback(const std::string& host) {
  in_addr address{};
  return inet_pton(AF_INET, host.c_str(), &address) == 1 && ntohl(address.s_addr) >> 24 == 127;
}

bool is_visible(char c) { return c > 0x20 && c < 0x7F; }

}  // namespace

Result<std::string> base_of(const std::string& url) {
  const Url parsed(curl_url());
  if (!parsed) return bad_server("not enough memory");
  const bool web = url.starts_with("http://") || url.starts_with("https://");
  if (!web) return bad_server("the address must begin with http:// or https://");
  if (curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), 0) != CURLUE_OK)
    return bad_server("this is not an address like https://HOST:PORT");
  if (has(parsed.get(), CURLUPART_USER) || has(parsed.get(), CURLUPART_PASSWORD)) {
    return bad_server("an address must not have a user or a password: give a key by --key-file or MESHGAUGE_KEY");
  }
  if (has(parsed.get(), CURLUPART_QUERY) || has(parsed.get(), CURLUPART_FRAGMENT)) {
    return bad_server("an address has no query or fragment: leave out what begins with '?' or '#'");
  }
  char* text = nullptr;
  if (curl_url_get(parsed.get(), CURLUPART_URL, &text, 0) != CURLUE_OK) return bad_server("the address cannot be used");
  std::string base = std::unique_ptr<char, Freed>(text).get();
  while (base.ends_with('/')) base.pop_back();
  return base;
}

std::string link_to(const std::string& base, const std::string& path) {
  return percent_encoded(base + path, "-._~:/%[]");
}

bool is_private(const std::string& base) {
  if (base.starts_with("https://")) return true;
  const std::string host = host_of(base);
  return host == "localhost" || host == "[::1]" || is_ipv4_loopback(host);
}

bool is_key(std::string_view key) { return !key.empty() && std::all_of(key.begin(), key.end(), is_visible); }

// A long name is cut at its beginning, since its suffix may decide the format.
std::string disposition(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  if (name.size() > kMostNameBytes) name.erase(0, name.size() - kMostNameBytes);
  for (char& c : name) {
    const bool plain = c == ' ' || is_visible(c);
    if (!plain || c == '"' || c == '\\') c = '_';
  }
  return "attachment; filename=\"" + name + "\"";
}

std::string one_line(std::string_view text, std::size_t most) {
  std::string out(text.substr(0, most));
  std::replace_if(out.begin(), out.end(), is_control, ' ');
  return text.size() > most ? out + "..." : out;
}

}  // namespace meshgauge::check::service
