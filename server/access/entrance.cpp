#include "server/access/entrance.h"

#include <algorithm>
#include <array>

#include "server/access/keys.h"

namespace meshgauge::server {
namespace {

// Paths that show nothing of any owner's data. Every other path needs a key, even one that does not exist.
constexpr std::array<std::string_view, 9> kOpen{
    "/", "/b", "/c", "/docs", "/gates.schema.json", "/healthz", "/openapi.yaml", "/problems", "/readyz"};
constexpr std::array<std::string_view, 5> kOpenFolders{"/b/", "/c/", "/docs/", "/page/", "/problems/"};

// The reason, for the metrics, why a request was not authenticated.
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
  if (const auto refusal = origins_.find_refusal(exchange.head)) return answer(exchange, *refusal), false;
  const auto caller = access_.authenticate(exchange.head);
  if (const auto* denial = std::get_if<Denial>(&caller)) {
    metrics_.auth_failed(failure_of(exchange.head));
    return answer(exchange, *denial), false;
  }
  const auto& known = std::get<Caller>(caller);
  exchange.owner = known.owner;
  // Rate before scope, so that forbidden requests are limited as well.
  if (const auto denial = access_.begin_request(known.owner)) return answer(exchange, *denial), false;
  if (const auto denial = Access::require(known, *scope)) {
    metrics_.auth_failed(AuthFailure::forbidden);
    return answer(exchange, *denial), false;
  }
  return true;
}

void answer(Exchange& exchange, const Denial& denial) {
  answer(exchange, denial.problem);
  auto& headers = exchange.response.headers;
  for (const auto& header : denial.headers) {  // replaces the default header of such a problem
    std::erase_if(headers, [&](const auto& other) { return other.first == header.first; });
    headers.push_back(header);
  }
}

}  // namespace meshgauge::server
