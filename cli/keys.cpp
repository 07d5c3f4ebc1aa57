#include <cstdio>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "cli/commands.h"
#include "server/access/keys.h"

namespace meshgauge::cli {
namespace {

struct KeyFlags {
  std::string id;
  std::vector<std::string> scopes{"compare"};
};

int make_key(const KeyFlags& flags) {
  if (const auto ok = server::check_key_id(flags.id); !ok) return fail(ok.error());
  server::Key key;
  key.id = flags.id;
  key.scopes = {};
  for (const std::string& name : flags.scopes) {
    (*server::scope_of(name) == server::Scope::compare ? key.scopes.compare : key.scopes.metrics) = true;
  }
  const std::string token = server::new_token();
  key.sha256 = {server::token_sha256(token)};
  std::printf("%s\n%s\n", token.c_str(), to_json(key).c_str());
  return kExitResult;
}

int hash_token() {
  std::string token;
  std::getline(std::cin, token);
  if (const auto ok = server::check_token(token); !ok) return fail(ok.error());
  std::printf("%s\n", server::token_sha256(token).c_str());
  return kExitResult;
}

}  // namespace

void add_keys(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand("keys", "Make bearer keys for --keys-file of `serve`");
  command.require_subcommand(1);
  const auto flags = std::make_shared<KeyFlags>();
  CLI::App& make = *command.add_subcommand(
      "new",
      "Print a new token, which is for the client and kept nowhere, and on the next line its entry for the file");
  make.add_option("id", flags->id, "Name of the owner: what is stored with the key belongs to it")->required();
  make.add_option("--scope", flags->scopes, "What it may be used for: compare, metrics; may be repeated")
      ->check(CLI::IsMember({"compare", "metrics"}))
      ->capture_default_str();
  make.callback([flags, &exit_code] { exit_code = make_key(*flags); });
  CLI::App& hash = *command.add_subcommand("hash", "Read a token of your own from standard input, print its sha256");
  hash.callback([&exit_code] { exit_code = hash_token(); });
}

}  // namespace meshgauge::cli
