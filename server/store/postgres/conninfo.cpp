#include "server/store/postgres/conninfo.h"

#include <memory>

#include <libpq-fe.h>

namespace meshgauge::server::store {
namespace {

struct Freed {
  void operator()(PQconninfoOption* options) const { PQconninfoFree(options); }
};

std::string quoted(const std::string& value) {
  if (!value.empty() && value.find_first_of(" '\\\t\n\r") == std::string::npos) return value;
  std::string text = "'";
  for (const char c : value) {
    if (c == '\'' || c == '\\') text += '\\';
    text += c;
  }
  return text + "'";
}

}  // namespace

std::string without_password(const std::string& database) {
  if (database.empty()) return "";
  const std::unique_ptr<PQconninfoOption, Freed> options(PQconninfoParse(database.c_str(), nullptr));
  if (!options) return "(not a connection string)";
  std::string text;
  for (const PQconninfoOption* option = options.get(); option->keyword != nullptr; ++option) {
    if (option->val == nullptr) continue;
    // libpq marks what must not be shown by a star.
    const bool secret = option->dispchar != nullptr && *option->dispchar == '*';
    text += (text.empty() ? "" : " ") + std::string(option->keyword) + "=" + (secret ? "***" : quoted(option->val));
  }
  return text;
}

}  // namespace meshgauge::server::store
