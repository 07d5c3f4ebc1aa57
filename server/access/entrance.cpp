#include "server/access/entrance.h"

#include <algorithm>
#include <array>

#include "server/access/token.h"

namespace meshgauge::server {
namespace {

// What says nothing about anybody's work. All else needs a key, also a path that there is not.
constexpr std::array<std::string_view, 7> kOpen{"/", "/b", "/c", "/docs", "/healthz", "/openapi.yaml", "/readyz"};
constexpr std::array<std::string_view, 4> kOpenFolders{"/b/", "/c/", "/docs/", "/page/"};

// Why a head was not authenticated.
AuthFailure failure_of(const Head& head) {
  if (!bearer_token(head).empty()) return AuthFailure::unknown;
  return head.header("authorization").empty() ? AuthFailure::missing : AuthFailure::malformed;
}

}  // namespace

std::optional<Scope> scope_of_path(std::string_view path) {
  const auto within = [&](std::string_view folder) { return path.starts_with(folder); };
  if (std::find(kOpen.begin(), kOpen.end(), path) != kOpen.end()) return std::nullopt;
  if (std::any_of(kOpenFolders.begin(), kOpenFolders.end(), within)) return std::nullopt;
  return path == "/metrics" ? Scope::metrics : Scope::compare;
}

bool Entrance::admit(Exchange& exchange) const {
  const auto scope = scope_of_path(exchange.head.path);
  if (!scope) return true;
  const auto caller = access_.authenticate(exchange.head);
  if (const auto* denial = std::get_if<Denial>(&caller)) {
    metrics_.auth_failed(failure_of(exchange.head));
    return answer(exchange, *denial), false;
  }
  const auto& who = std::get<Caller>(caller);
  exchange.owner = who.owner;
  // The rate first: a key that may not do this must not ask without end.
  if (const auto denial = access_.begin_request(who.owner)) return answer(exchange, *denial), false;
  if (const auto denial = Access::require(who, *scope)) {
    metrics_.auth_failed(AuthFailure::forbidden);
    return answer(exchange, *denial), false;
  }
  return true;
}

void answer(Exchange& exchange, const Denial& denial) {
  answer(exchange, denial.problem);
  auto& headers = exchange.response.headers;
  for (const auto& header : denial.headers) {  // what the denial says counts more than what any such problem says
    std::erase_if(headers, [&](const auto& other) { return other.first == header.first; });
    headers.push_back(header);
  }
}

}  // namespace meshgauge::server
