// Web pages of other origins: which of them may read responses, and, for a service without keys, the refusal of what
// the others ask for.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/base/problem.h"
#include "engine/result.h"
#include "server/http/exchange.h"
#include "server/http/head.h"
#include "server/http/target.h"

namespace meshgauge::server {

// Cross-origin resource sharing: which origins' web pages may read responses. By default none.
class Cors {
 public:
  // Parses a list such as "https://a.example, http://localhost:3000": each exactly as browsers send it in Origin. '*'
  // is an Error.
  static Result<Cors> parse(std::string_view origins);

  // Adds the CORS headers to the response if the request's origin is in the list.
  void add_headers(Exchange& exchange) const;

  // Answers a preflight request with 204. False: the request is not one, or its origin is not in the list.
  bool answer_preflight(Exchange& exchange) const;

  bool allows(std::string_view origin) const;

 private:
  std::vector<std::string> origins_;
};

// Refuses requests that web pages of other sites make, for a service without keys.
//
// A key is sent by a page's script alone, so no other site can use it. Without keys any page that a user of this
// machine opens could reach the service: by a form or a script, whose Origin names the page's site, or under a name of
// its own that it makes resolve to this machine (DNS rebinding), which is then in Host.
class OriginCheck {
 public:
  enum class Hosts { any, listed };

  OriginCheck() = default;  // refuses nothing: for a service with keys

  // `allowed_hosts`: a list such as "gauge.example, gauge.lan": names without a port, beside localhost and
  // addresses. With Hosts::any and an empty list, Host may be anything. An Error names what is not a host.
  static Result<OriginCheck> parse(std::string_view allowed_hosts, Hosts hosts, Cors cors);

  // Returns the refusal of a request to another host, or of one that changes something and comes from a page of another
  // site, unless CORS allows that site. nullopt: neither. A request without Host or Origin is not a browser's.
  std::optional<api::Problem> find_refusal(const Head& head) const;

 private:
  bool is_own(const Authority& authority) const;

  bool active_ = false;
  bool any_host_ = false;
  std::vector<std::string> hosts_;
  Cors cors_;
};

}  // namespace meshgauge::server
