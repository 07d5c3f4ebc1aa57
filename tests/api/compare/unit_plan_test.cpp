#include "api/compare/unit_plan.h"

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

using namespace meshgauge;
using api::AskedUnits;
using api::FileUnit;
using api::Format;
using api::LengthUnit;
using api::parse_unit;

namespace {

using Row =
    std::vector<std::string>;  // a, size, declared, b, size, declared, limit, unit, source, distance, verdict, says

std::vector<Row> table() {
  std::ifstream file(MESHGAUGE_SOURCE_DIR "/tests/units/units.tsv");
  std::vector<Row> rows;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream cells(line);
    Row row;
    for (std::string cell; std::getline(cells, cell, '\t');) row.push_back(cell);
    REQUIRE(row.size() == 12);
    rows.push_back(row);
  }
  return rows;
}

std::optional<LengthUnit> unit_of(const std::string& cell) {
  const auto unit = parse_unit(cell);
  CHECK((cell == "-") != unit.has_value());
  return unit;
}

FileUnit file_of(const std::string& cell) {
  if (cell.starts_with("3mf:")) return {Format::three_mf, unit_of(cell.substr(4))};
  if (cell == "glb") return {Format::glb, LengthUnit::meter};
  if (cell == "gltf") return {Format::gltf, LengthUnit::meter};
  for (const Format format : {Format::stl, Format::obj, Format::ply, Format::off}) {
    if (cell == to_string(format)) return {format, std::nullopt};
  }
  FAIL("no format: " << cell);
  return {};
}

}  // namespace

TEST_CASE("units: a factor is a quotient of small integers, and 1 for unknown units") {
  const auto factor = [](LengthUnit from, LengthUnit to) {
    return api::factor_between({from, api::UnitSource::file}, {to, api::UnitSource::declared});
  };
  CHECK(factor(LengthUnit::inch, LengthUnit::millimeter) == Factor{127, 5});
  CHECK(factor(LengthUnit::meter, LengthUnit::inch) == Factor{5000, 127});
  CHECK(factor(LengthUnit::foot, LengthUnit::inch) == Factor{12, 1});
  for (const LengthUnit from : api::kLengthUnits) {
    CHECK(factor(from, from).is_one());
    CHECK(api::factor_between({from, api::UnitSource::file}, {}).is_one());
    CHECK(api::factor_between({}, {from, api::UnitSource::file}).is_one());
    for (const LengthUnit to : api::kLengthUnits) {
      const Factor there = factor(from, to), back = factor(to, from);
      CHECK(there.times == back.over);
      CHECK(there.over == back.times);
      CHECK(std::max(there.times, there.over) <= Factor::kMost);
    }
  }
}

TEST_CASE("units: the truth table") {
  const auto rows = table();
  CHECK(rows.size() >= 60);
  for (const Row& row : rows) {
    CAPTURE(row);
    AskedUnits asked;
    asked.a = unit_of(row[2]);
    asked.b = unit_of(row[5]);
    const std::size_t blank = row[6].find(' ');
    if (blank != std::string::npos) asked.limit = unit_of(row[6].substr(blank + 1));
    const auto plan = resolve(file_of(row[0]), file_of(row[3]), asked, row[6] != "-" ? "max_distance" : "");
    CHECK(plan.ok() == (row[10] != "error"));
    if (!plan) {
      CHECK(plan.error().code == ErrorCode::unit_conflict);
      CHECK(plan.error().message.find(row[11]) != std::string::npos);
      for (const char* mesh : {"'a'", "'b'"}) CHECK(plan.error().message.find(mesh) != std::string::npos);
      CHECK(plan.error().message.starts_with("max_distance "));
      continue;
    }
    CHECK(plan->result.unit == unit_of(row[7]));
    CHECK(to_string(plan->result.source) == row[8]);
  }
}

TEST_CASE("units: a conflict names the option that has the unit") {
  const FileUnit unknown{Format::stl, {}}, metres{Format::glb, LengthUnit::meter};
  const FileUnit inches{Format::three_mf, LengthUnit::inch};
  AskedUnits asked;
  CHECK(resolve(metres, inches, asked, "zone").error().message.starts_with("zone has no unit, "));
  CHECK(resolve(metres, inches, asked, "").ok());
  asked.limit = LengthUnit::millimeter;
  CHECK(resolve(metres, unknown, asked, "zone").error().message.starts_with("zone is in millimetres, "));
}

TEST_CASE("units: a limit in the unit of mesh b is never refused") {
  for (const FileUnit& a : {FileUnit{Format::stl, {}}, FileUnit{Format::glb, LengthUnit::meter}}) {
    for (const FileUnit& b : {FileUnit{Format::stl, {}}, FileUnit{Format::three_mf, LengthUnit::inch}}) {
      AskedUnits asked;
      asked.limit_of_b = true;
      const auto plan = resolve(a, b, asked, "max_distance");
      REQUIRE(plan.ok());
      CHECK(plan->result.unit == (a.unit ? b.unit : std::nullopt));
      CHECK(api::factor_between(plan->b, plan->result).is_one());
    }
  }
}
