#include "server/web/reference.h"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>

#include "server/web/assets.h"

namespace meshgauge::server {
namespace {

using api::Problem;
using api::ProblemKind;

constexpr std::string_view kPage = "docs.html";

// No script or style within the page, nothing from elsewhere, no frame around it. The pictures are in the style sheet.
constexpr const char* kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

constexpr std::array<std::pair<std::string_view, const char*>, 4> kTypes{{{".html", "text/html; charset=utf-8"},
                                                                          {".js", "text/javascript; charset=utf-8"},
                                                                          {".css", "text/css; charset=utf-8"},
                                                                          {".png", "image/png"}}};

const char* type_of(std::string_view name) {
  const auto* const found =
      std::find_if(kTypes.begin(), kTypes.end(), [&](const auto& type) { return name.ends_with(type.first); });
  return found == kTypes.end() ? "text/plain; charset=utf-8" : found->second;
}

const Asset* find(std::string_view name) {
  const auto found = std::find_if(assets().begin(), assets().end(), [&](const Asset& one) { return one.name == name; });
  return found == assets().end() ? nullptr : &*found;
}

void send(Exchange& exchange, const Asset& asset) {
  exchange.response.content_type = type_of(asset.name);
  exchange.response.body = asset.bytes;
}

}  // namespace

void show_reference(Exchange& exchange) {
  const Asset* page = find(kPage);
  if (!page) {
    const Problem without{ProblemKind::not_found,
                          "this service was built without its reference page, for which npm is needed; /openapi.yaml "
                          "is what it would show",
                          {}};
    return answer(exchange, without);
  }
  exchange.response.headers.emplace_back("Content-Security-Policy", kPolicy);
  send(exchange, *page);
}

void send_reference_file(Exchange& exchange) {
  const Asset* file = exchange.segment == kPage ? nullptr : find(exchange.segment);
  if (!file) return answer(exchange, Problem{ProblemKind::not_found, "the page /docs has no such file", {}});
  exchange.response.headers.emplace_back("Cache-Control", "public, max-age=3600");
  send(exchange, *file);
}

}  // namespace meshgauge::server
