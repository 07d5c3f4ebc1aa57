// A multipart body on its way through the parser and the form: the first line is its Content-Type, the rest the body.
// Asserted: however the body is cut into pieces, the same parts arrive, the same form and the same refusal; the budget
// gets back what it gave; sizes stay within their limits.
#include <string>

#include "server/http/comparison_form.h"
#include "server/http/multipart.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using Refusal = std::optional<api::Problem>;

// All that the parser tells, as one text.
struct Transcript final : server::MultipartSink {
  std::string text;

  Refusal begin(const server::FieldHead& field) override {
    text += "part " + field.name + '\n' + field.filename + '\n' + field.content_type + '\n';
    return std::nullopt;
  }
  Refusal data(std::string_view piece) override {
    text += piece;
    return std::nullopt;
  }
  Refusal end() override {
    text += "\nend\n";
    return std::nullopt;
  }
};

// The whole body when `longest` is 0.
Refusal feed(std::string_view body, const std::string& boundary, std::size_t longest, Dice& dice,
             server::MultipartSink& sink) {
  server::MultipartParser parser(boundary, sink);
  Refusal refusal;
  if (longest == 0) {
    refusal = parser.feed(body);
  } else {
    in_pieces(body, longest, dice, [&](std::string_view piece) {
      const std::string exact(piece);
      refusal = parser.feed(exact);
      return !refusal;
    });
  }
  return refusal ? refusal : parser.finish();
}

std::string told(const Refusal& refusal) { return refusal ? refusal->detail + '\n' : "complete\n"; }

std::string parsed(std::string_view body, const std::string& boundary, std::size_t longest, Dice& dice) {
  Transcript transcript;
  const auto refusal = feed(body, boundary, longest, dice, transcript);
  return transcript.text + told(refusal);
}

std::string told(const server::MeshField& field, const server::Settings& settings) {
  const auto bytes = field.upload->bytes();
  require(bytes.size() == field.upload->size() && bytes.size() <= settings.max_part_bytes,
          "a part is within its limit");
  return field.head.filename + '\n' + field.head.content_type + '\n' +
         std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()) + '\n';
}

std::string received(std::string_view body, const std::string& boundary, std::size_t longest, Dice& dice) {
  static const server::Settings settings = [] {
    server::Settings small;
    small.max_part_bytes = 1000;
    return small;
  }();
  server::ByteBudget budget(1 << 20);  // never used up: what is left of it decides at each piece
  std::string out;
  {
    server::Form form;
    server::FormReceiver receiver(form, settings, budget);
    auto refusal = feed(body, boundary, longest, dice, receiver);
    if (!refusal) refusal = receiver.complete();
    if (longest == 0 && refusal) require_answer(*refusal);
    out = told(refusal);
    require(budget.used() <= budget.max_bytes(), "uploads stay within the budget");
    if (!refusal) out += told(form.a, settings) + told(form.b, settings) + form.options;
  }
  require(budget.used() == 0, "the budget gets back what it gave");
  return out;
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(multipart) {
  using namespace meshgauge::fuzz;
  const auto input = text_of(data, size);
  const std::size_t line = std::min(input.find('\n'), input.size());
  const auto body = input.substr(std::min(line + 1, input.size()));
  std::string boundary;
  if (const auto refusal = meshgauge::server::find_boundary(input.substr(0, line), "multipart/form-data", boundary)) {
    require_answer(*refusal);
    return 0;
  }
  Dice dice = dice_of(input);
  const std::string parts = parsed(body, boundary, 0, dice);
  const std::string form = received(body, boundary, 0, dice);
  for (const std::size_t longest : {1 + body.size() / 1024, std::size_t{64}, std::size_t{1024}}) {
    require(parsed(body, boundary, longest, dice) == parts, "the parts do not depend on how the body is cut", parts);
    require(received(body, boundary, longest, dice) == form, "the form does not depend on how the body is cut", form);
  }
  return 0;
}
