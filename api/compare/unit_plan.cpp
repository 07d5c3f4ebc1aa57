#include "api/compare/unit_plan.h"

#include <cstdint>
#include <numeric>
#include <string>
#include <utility>

namespace meshgauge::api {
namespace {

std::int64_t micrometres(LengthUnit unit) {
  constexpr std::int64_t kLengths[] = {1, 1'000, 10'000, 1'000'000, 25'400, 304'800};
  return kLengths[static_cast<std::size_t>(unit)];
}

KnownUnit known(const FileUnit& file, const std::optional<LengthUnit>& declared) {
  if (declared) return {declared, UnitSource::declared};
  if (file.unit) return {file.unit, UnitSource::file};
  return {};
}

std::string quoted(const FileUnit& file, const char* part) {
  return "'" + std::string(file.name.empty() ? std::string_view(part) : file.name) + "'";
}

// "'part.glb' is in metres (as every glTF)".
std::string described(const FileUnit& file, const char* part, const KnownUnit& known) {
  const std::string name = quoted(file, part);
  if (!known.unit)
    return "the unit of " + name + " is not known (" + std::string(to_string(file.format)) + " has none)";
  const bool fixed = file.format == Format::gltf || file.format == Format::glb;
  const char* how = fixed ? "as every glTF" : "as its file says";
  if (known.source == UnitSource::declared) how = "declared";
  return name + " is in " + std::string(in_words(*known.unit)) + " (" + how + ")";
}

std::string described(const UnitPlan& plan, const FileUnit& a, const FileUnit& b) {
  return described(a, "a", plan.a) + " and " + described(b, "b", plan.b);
}

Error conflict(std::string message, std::string part, std::string where) {
  return {ErrorCode::unit_conflict, std::move(message), std::move(part), std::move(where)};
}

Error one_is_unknown(const UnitPlan& plan, const FileUnit& a, const FileUnit& b, std::string_view option,
                     LengthUnit unit) {
  const std::string part = plan.a.unit ? "b" : "a";
  const std::string name = plan.a.unit ? quoted(b, "b") : quoted(a, "a");
  return conflict(std::string(option) + " is in " + std::string(in_words(unit)) + ", " + described(plan, a, b) +
                      ": declare the unit of " + name + " (option units." + part + ", flag --unit-" + part +
                      ", or units in a manifest)",
                  part, "/units/" + part);
}

Error bare_length(const UnitPlan& plan, const FileUnit& a, const FileUnit& b, std::string_view option) {
  return conflict(
      std::string(option) + " has no unit, " + described(plan, a, b) + ": write it with its unit, as '0.05 mm'",
      "options", "/gate/units");
}

}  // namespace

Result<UnitPlan> resolve(const FileUnit& a, const FileUnit& b, const AskedUnits& asked, std::string_view option) {
  UnitPlan plan{known(a, asked.a), known(b, asked.b), {}};
  const bool any = plan.a.unit || plan.b.unit, both = plan.a.unit && plan.b.unit;
  const bool has_length = !option.empty();
  if (has_length && asked.limit) {
    if (any && !both) return one_is_unknown(plan, a, b, option, *asked.limit);
    plan.result = {asked.limit, both ? UnitSource::declared : UnitSource::assumed};
    if (!both) plan.a = plan.b = plan.result;
    return plan;
  }
  const bool bare = has_length && !asked.limit_of_b && !asked.limit_of_diagonal;
  if (bare && both && plan.a.unit != plan.b.unit) return bare_length(plan, a, b, option);
  if (both) plan.result = plan.b;
  return plan;
}

Factor factor_between(const KnownUnit& mesh, const KnownUnit& result) {
  if (!mesh.unit || !result.unit) return {};
  const std::int64_t times = micrometres(*mesh.unit), over = micrometres(*result.unit);
  const std::int64_t common = std::gcd(times, over);
  const std::int64_t numerator = times / common, denominator = over / common;
  return {static_cast<double>(numerator), static_cast<double>(denominator)};
}

}  // namespace meshgauge::api
