// Receives the body of a comparison: a form with both files, or a JSON document that names stored meshes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "api/base/problem.h"
#include "server/http/comparison_form.h"
#include "server/http/exchange.h"
#include "server/http/multipart.h"
#include "server/http/upload.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

class ComparisonBody {
 public:
  using Refusal = std::optional<api::Problem>;

  // Borrows the settings and the budget of the share.
  ComparisonBody(const Settings& settings, const UploadShare& share) : receiver_(form_, settings, share) {}
  ComparisonBody(const ComparisonBody&) = delete;
  ComparisonBody& operator=(const ComparisonBody&) = delete;

  // Begins to read the body. `end` is called with nullopt when all of it has arrived, and a form is complete, else with
  // the problem. `self`: keeps this object until then. Call once.
  static void receive(const std::shared_ptr<ComparisonBody>& self, Exchange& exchange, Body::End end);

  // After the end.
  bool is_form() const { return parser_.has_value(); }
  Form& form() { return form_; }
  const std::string& text() const { return text_; }  // the JSON document, if it is no form

 private:
  Refusal expect(const Head& head);
  Refusal take(std::string_view piece);
  Refusal complete();

  Form form_;
  FormReceiver receiver_;
  std::optional<MultipartParser> parser_;  // null: the body is JSON
  std::string text_;
};

// Adds a piece of a JSON body of at most api::kMaxOptionsBytes.
std::optional<api::Problem> add_piece(std::string& text, std::string_view piece);

}  // namespace meshgauge::server
