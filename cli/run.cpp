#include "cli/run.h"

#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/base/suggestion.h"
#include "cli/commands.h"
#include "engine/hausdorff.h"

namespace meshgauge::cli {
namespace {

using api::suggestion;

// Returns the words of the command line that no subcommand or flag takes, or an empty text.
std::string unknown_words(const CLI::App& app, const CLI::App* subcommand) {
  const std::vector<std::string> extras = app.remaining(true);
  if (extras.empty()) return "";
  std::vector<std::string> known;
  if (!subcommand) {
    for (const CLI::App* one : app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); }))
      known.push_back(one->get_name());
  } else {
    for (const CLI::Option* option : subcommand->get_options())
      for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }
  const auto flag = std::find_if(extras.begin(), extras.end(), [](const auto& word) { return word.starts_with("--"); });
  const std::string word = flag == extras.end() ? extras.front() : *flag;
  const std::vector<std::string_view> names(known.begin(), known.end());
  const std::string_view near = api::nearest(word, names);
  if (!subcommand && !word.starts_with('-')) return "there is no subcommand '" + word + "'" + suggestion(word, names);
  const std::string name = subcommand ? subcommand->get_name() : "meshgauge";
  return "'" + name + "' takes no '" + word + "'" + (near.empty() ? "" : suggestion(word, names));
}

// Returns what is wrong with a value that is not a number. CLI11: "Could not convert: --port = many".
std::string not_a_number(const std::string& message) {
  const auto colon = message.find(": "), equals = message.find(" = ");
  if (colon == std::string::npos || equals == std::string::npos || equals < colon) return message;
  return message.substr(colon + 2, equals - colon - 2) + " must be a number, not '" + message.substr(equals + 3) + "'";
}

// Returns the message of a mistake in the command line. CLI11 would report an unknown subcommand as a missing one.
std::string mistake(const CLI::App* app, const CLI::Error& error) {
  const auto chosen = app->get_subcommands();
  const CLI::App* subcommand = chosen.empty() ? nullptr : chosen.front();
  const bool required = error.get_name() == "RequiredError" && subcommand;
  const std::string unknown = required ? "" : unknown_words(*app, subcommand);
  const std::string help = subcommand ? "meshgauge " + subcommand->get_name() + " --help" : "meshgauge --help";
  const std::string known = error.get_name() == "ConversionError" ? not_a_number(error.what()) : error.what();
  return "meshgauge: " + (unknown.empty() ? known : unknown) + "\nRun '" + help + "' for help.\n";
}

}  // namespace

int run(int argc, char** argv, const std::function<void(CLI::App&, int&)>& add) try {
  CLI::App app{"Certified Hausdorff distance between triangle meshes", "meshgauge"};
  app.set_version_flag("--version", std::string("meshgauge ") + version());
  app.require_subcommand(1);
  app.failure_message(mistake);
  int exit_code = kExitError;
  add(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : kExitError;  // --help and --version are "errors" of code 0
  }
  return exit_code;
} catch (const std::exception& error) {
  std::fprintf(stderr, "meshgauge: %s\n", error.what());
  return kExitError;
}

}  // namespace meshgauge::cli
