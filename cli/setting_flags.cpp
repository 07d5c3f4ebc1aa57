#include "cli/setting_flags.h"

#include <algorithm>
#include <string>

#include <CLI/CLI.hpp>

#include "server/main/settings_file.h"

namespace meshgauge::cli {
namespace {

struct AskedSettings {
  std::string config;
  server::Settings settings;  // written by the flags; only those that were given count
};

std::string flag_of(std::string name) {
  std::replace(name.begin(), name.end(), '_', '-');
  return "--" + name;
}

std::string variable_of(std::string name) {
  std::transform(name.begin(), name.end(), name.begin(),
                 [](char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; });
  return "MESHGAUGE_" + name;
}

CLI::Option* add(CLI::App& command, const std::string& flag, bool& field, const char* help) {
  return command.add_flag(flag, field, help);
}

template <class Field>
CLI::Option* add(CLI::App& command, const std::string& flag, Field& field, const char* help) {
  return command.add_option(flag, field, help)->capture_default_str();
}

// Reads the file first, then applies flags and variables.
Result<server::Settings> gathered(const CLI::App& command, const AskedSettings& asked) {
  server::Settings settings;
  if (!asked.config.empty()) {
    if (auto ok = server::load_settings(asked.config, settings); !ok) return ok.error();
  }
  for_each_setting(settings, [&](const server::SettingText& text, auto& field) {
    const CLI::Option* option = command.get_option_no_throw(flag_of(text.name));
    if (option && option->count() > 0) option->results(field);
  });
  return settings;
}

}  // namespace

std::function<Result<server::Settings>()> add_settings(CLI::App& command,
                                                       const std::function<bool(std::string_view name)>& wanted) {
  const auto asked = std::make_shared<AskedSettings>();
  command.add_option("--config", asked->config, "File with lines `name = value` of these settings, '_' for '-'")
      ->envname("MESHGAUGE_CONFIG");
  server::for_each_setting(asked->settings, [&](const server::SettingText& text, auto& field) {
    if (wanted(text.name)) add(command, flag_of(text.name), field, text.help)->envname(variable_of(text.name));
  });
  return [&command, asked] { return gathered(command, *asked); };
}

}  // namespace meshgauge::cli
