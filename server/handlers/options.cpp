#include "server/handlers/options.h"

#include <memory>

#include <nlohmann/json.hpp>

#include "api/request.h"
#include "server/http/parameters.h"

namespace meshgauge::server {

std::optional<api::Problem> add_piece(std::string& text, std::string_view piece) {
  if (text.size() + piece.size() > api::kMaxOptionsBytes) {
    return api::Problem{api::ProblemKind::too_large,
                        "the body is larger than the limit of " + std::to_string(api::kMaxOptionsBytes) + " bytes",
                        {}};
  }
  text.append(piece);
  return std::nullopt;
}

void read_options(Exchange& exchange, const Settings& settings) {
  if (auto refusal = refuse_query(exchange)) return answer(exchange, *refusal);
  std::string_view type = exchange.head.header("content-type");
  if (take_kind(type) != "application/json") {
    constexpr const char* kWanted = "Content-Type must be application/json, the options of a comparison";
    return answer(exchange, api::Problem{api::ProblemKind::unsupported_media_type, kWanted, {}});
  }
  const auto text = std::make_shared<std::string>();
  exchange.body.read([text](std::string_view piece) { return add_piece(*text, piece); },
                     [&exchange, text, limits = request_limits(settings)](const auto& lost) {
                       if (lost) return answer(exchange, *lost);
                       const auto request = api::parse_options(*text, limits);
                       if (!request) return answer(exchange, api::to_problem(request.error()));
                       exchange.response.content_type = "application/json";
                       exchange.response.body = api::json_of(*request).dump();
                     });
}

}  // namespace meshgauge::server
