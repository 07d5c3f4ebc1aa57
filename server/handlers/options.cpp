#include "server/handlers/options.h"

#include <memory>

#include <nlohmann/json.hpp>

#include "api/request.h"

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
