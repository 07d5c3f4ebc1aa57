#include "tests/fuzz/targets/checks.h"

#include <cstdio>
#include <cstdlib>

#include <nlohmann/json.hpp>

namespace meshgauge::fuzz {

void require(bool holds, const char* what, std::string_view details) {
  if (holds) return;
  std::fprintf(stderr, "does not hold: %s\n%.*s\n", what, static_cast<int>(details.size()), details.data());
  std::abort();
}

void require_answer(const api::Problem& problem) {
  require(problem.kind != api::ProblemKind::internal, "nothing that a client sends is an internal failure",
          problem.detail);
  require(!problem.detail.empty(), "a refusal says why");
  const std::string json = to_json(problem);
  require(nlohmann::json::accept(json), "a problem document is JSON", json);
}

void require_answer(const Error& error) { require_answer(api::to_problem(error)); }

Dice dice_of(std::string_view bytes) {
  std::uint64_t hash = 0xCBF29CE484222325;  // FNV-1a
  for (const char c : bytes) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3;
  return Dice(hash);
}

}  // namespace meshgauge::fuzz
