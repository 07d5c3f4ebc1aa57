// fuzz_certify: attacks the engine with small pairs of meshes and checks every outcome by exact arithmetic; by name
// also the areas, the regions and the sides.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>

#include "fuzz/attacks.h"
#include "fuzz/campaign.h"
#include "today.h"

namespace {

struct Attack {
  const char* name;
  const char* what;
  bool (*run)(std::uint64_t pairs, std::uint64_t seed);
};
constexpr Attack kAttacks[] = {
    {"areas", "certified areas", meshgauge::fuzz::attack_areas},
    {"regions", "certified distances within regions", meshgauge::fuzz::attack_regions},
    {"sides", "the certified extent on each side", meshgauge::fuzz::attack_sides},
};

}  // namespace

int main(int argc, char** argv) {
  meshgauge::fuzz::Settings settings;
  settings.threads = std::max(1U, std::thread::hardware_concurrency());
  CLI::App app(
      "Attacks the engine with random and adversarial pairs; an exact oracle checks every answer. "
      "Exits 1 at the first violation, after shrinking it.");
  app.add_option("--seconds", settings.seconds, "stop after this time; 0: no limit")->check(CLI::NonNegativeNumber);
  app.add_option("--pairs", settings.pairs, "stop after this many pairs; 0: no limit");
  settings.seed = meshgauge::today();
  app.add_option("--seed", settings.seed, "pair i is made from seed + i; today's date by default")
      ->capture_default_str();
  app.add_option("--threads", settings.threads)->check(CLI::Range(1, 256))->capture_default_str();
  std::vector<std::string> names;
  for (const auto& method : meshgauge::fuzz::methods()) names.emplace_back(method.name);
  app.add_option("--strategy", settings.strategy, "only this one")->check(CLI::IsMember(names));
  app.add_flag("--keep-going", settings.keep_going, "count violations and show the first of each kind");
  std::uint64_t pairs = 1000;
  for (const Attack& attack : kAttacks) {
    CLI::App* part = app.add_subcommand(attack.name, std::string("attack ") + attack.what + " instead");
    part->add_option("--pairs", pairs)->capture_default_str();
    part->add_option("--seed", settings.seed)->capture_default_str();
  }
  app.require_subcommand(0, 1);
  CLI11_PARSE(app, argc, argv);
  std::printf("seed %llu\n", static_cast<unsigned long long>(settings.seed));
  for (const Attack& attack : kAttacks) {
    if (app.got_subcommand(attack.name)) return attack.run(pairs, settings.seed) ? 0 : 1;
  }
  if (settings.seconds == 0 && settings.pairs == 0) settings.seconds = 60;
  return meshgauge::fuzz::Campaign(settings).run() ? 0 : 1;
}
