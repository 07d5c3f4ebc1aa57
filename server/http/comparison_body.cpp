#include "server/http/comparison_body.h"

#include <utility>

#include "api/options/request.h"
#include "server/http/head_values.h"

namespace meshgauge::server {

void ComparisonBody::receive(const std::shared_ptr<ComparisonBody>& self, Exchange& exchange, Body::End end) {
  if (const auto refusal = self->expect(exchange.head)) return end(refusal);
  exchange.body.read([self](std::string_view piece) { return self->take(piece); },
                     [self, end = std::move(end)](const Refusal& lost) { end(lost ? lost : self->complete()); });
}

ComparisonBody::Refusal ComparisonBody::expect(const Head& head) {
  std::string_view type = head.header("content-type");
  if (take_kind(type) == "application/json") return std::nullopt;
  std::string boundary;
  constexpr const char* kWanted =
      "multipart/form-data for files (curl -F a=@part.stl -F b=@baseline.stl), or application/json for stored meshes "
      "(curl --json '{\"a\": \"SHA-256\", \"b\": \"SHA-256\"}')";
  if (auto refusal = find_boundary(head.header("content-type"), kWanted, boundary)) return refusal;
  parser_.emplace(boundary, receiver_);
  return std::nullopt;
}

ComparisonBody::Refusal ComparisonBody::take(std::string_view piece) {
  return parser_ ? parser_->feed(piece) : add_piece(text_, piece);
}

ComparisonBody::Refusal ComparisonBody::complete() {
  if (!parser_) return std::nullopt;
  if (auto refusal = parser_->finish()) return refusal;
  return receiver_.complete();
}

std::optional<api::Problem> add_piece(std::string& text, std::string_view piece) {
  if (text.size() + piece.size() > api::kMaxOptionsBytes) {
    return api::Problem{api::ProblemKind::too_large,
                        "the body is larger than the limit of " + std::to_string(api::kMaxOptionsBytes) + " bytes"};
  }
  text.append(piece);
  return std::nullopt;
}

}  // namespace meshgauge::server
