// Which web pages' scripts may read the answers (CORS): none, but those of the origins that are named.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "engine/result.h"
#include "server/http/exchange.h"

namespace meshgauge::server {

class Cors {
 public:
  // "https://a.example, http://localhost:3000": each exactly as a browser sends it in Origin. There is no '*'.
  static Result<Cors> parse(std::string_view origins);

  // Adds what a browser must see on an answer to a page of such an origin.
  void add_headers(Exchange& exchange) const;

  // Answers a browser's question whether it may send a request. False: it was none, or of another origin.
  bool answer_preflight(Exchange& exchange) const;

 private:
  bool allows(std::string_view origin) const;

  std::vector<std::string> origins_;
};

}  // namespace meshgauge::server
