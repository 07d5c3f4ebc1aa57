// Writes what schemas and other programs are to read: write_reports FOLDER.
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "check/reports/code_quality.h"
#include "check/reports/junit.h"
#include "check/reports/markdown.h"
#include "check/reports/sample_reports.h"
#include "check/reports/sarif.h"

namespace {

bool write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  return static_cast<bool>(out << text << std::flush);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: write_reports FOLDER\n"), 3;
  const std::filesystem::path folder = argv[1];
  bool ok = true;
  for (const auto& [name, report] : meshgauge::check::samples::all()) {
    ok = ok && write(folder / (std::string(name) + ".xml"), to_junit(report));
    ok = ok && write(folder / (std::string(name) + ".sarif"), to_sarif(report));
    ok = ok && write(folder / (std::string(name) + ".md"), to_markdown(report));
    ok = ok && write(folder / (std::string(name) + ".codequality.json"), to_code_quality(report));
  }
  return ok ? 0 : 3;
}
