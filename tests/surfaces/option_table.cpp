// Prints the table of options (api/options/table.h) as JSON, for tests/surfaces/table.py.
#include <cstdio>

#include <nlohmann/json.hpp>

#include "api/options/names.h"
#include "api/options/table.h"

using namespace meshgauge::api;

namespace {

constexpr Name<OptionKind> kKinds[] = {{OptionKind::length, "length"}, {OptionKind::limit, "limit"},
                                       {OptionKind::count, "count"},   {OptionKind::choice, "choice"},
                                       {OptionKind::toggle, "toggle"}, {OptionKind::time, "time"},
                                       {OptionKind::shape, "shape"}};

constexpr Name<Surface::Bit> kSurfaces[] = {
    {Surface::http, "http"}, {Surface::manifest, "manifest"}, {Surface::flags, "flags"}, {Surface::python, "python"}};

Json row_of(const Option& option) {
  Json row{{"key", option.key}, {"kind", name_of(kKinds, option.kind)}, {"surfaces", Json::array()}};
  for (const auto& [bit, name] : kSurfaces) {
    if ((option.surfaces & bit) != 0) row["surfaces"].push_back(name);
  }
  row["help"] = option.help;
  row["usual"] = option.usual;
  row["example"] = option.example;
  if (option.words) row["words"] = option.words();
  if (option.kind == OptionKind::count) row["range"] = {option.range.low, option.range.high};
  return row;
}

}  // namespace

int main() {
  Json table = Json::array();
  for (const Option* option : all_options()) table.push_back(row_of(*option));
  std::puts(table.dump(1).c_str());
}
