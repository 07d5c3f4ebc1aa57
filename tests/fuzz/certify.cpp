// fuzz_certify: attacks the engine with small pairs of meshes and checks every outcome by exact arithmetic.
#include <algorithm>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "fuzz/campaign.h"

int main(int argc, char** argv) {
  meshgauge::fuzz::Settings settings;
  settings.threads = std::max(1U, std::thread::hardware_concurrency());
  CLI::App app(
      "Attacks the engine with random and adversarial pairs; an exact oracle checks every answer. "
      "Exits 1 at the first violation, after shrinking it.");
  app.add_option("--seconds", settings.seconds, "stop after this time; 0: no limit")->check(CLI::NonNegativeNumber);
  app.add_option("--pairs", settings.pairs, "stop after this many pairs; 0: no limit");
  app.add_option("--seed", settings.seed, "pair i is made from seed + i")->capture_default_str();
  app.add_option("--threads", settings.threads)->check(CLI::Range(1, 256))->capture_default_str();
  std::vector<std::string> names;
  for (const auto& method : meshgauge::fuzz::methods()) names.emplace_back(method.name);
  app.add_option("--strategy", settings.strategy, "only this one")->check(CLI::IsMember(names));
  app.add_flag("--keep-going", settings.keep_going, "count violations and show the first of each kind");
  CLI11_PARSE(app, argc, argv);
  if (settings.seconds == 0 && settings.pairs == 0) settings.seconds = 60;
  return meshgauge::fuzz::Campaign(settings).run() ? 0 : 1;
}
