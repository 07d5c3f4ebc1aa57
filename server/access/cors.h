// Cross-origin resource sharing: which origins' web pages may read responses. By default none.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"
#include "server/http/exchange.h"

namespace meshgauge::server {

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

}  // namespace meshgauge::server
