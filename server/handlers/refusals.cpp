#include "server/handlers/refusals.h"

namespace meshgauge::server {

std::shared_ptr<const void> take_place(Exchange& exchange, ConnectionLimit& watchers, const Settings& settings) {
  if (exchange.head.minor_version == 0) {
    answer(exchange, api::Problem{api::ProblemKind::http_version, "this path streams its response: send HTTP/1.1"});
    return nullptr;
  }
  auto place = watchers.take(client_of(exchange));
  if (!place) answer(exchange, too_many_watchers(settings));
  return place;
}

}  // namespace meshgauge::server
