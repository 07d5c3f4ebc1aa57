#include "server/store/conninfo.h"

#include <libpq-fe.h>

#include <memory>
#include <string_view>

namespace meshgauge::server::store {
namespace {

using Options = std::unique_ptr<PQconninfoOption, decltype(&PQconninfoFree)>;

// libpq's message is dropped: it may quote a part of a password.
Options parsed(const std::string& text) {
  char* message = nullptr;
  Options options(PQconninfoParse(text.c_str(), &message), &PQconninfoFree);
  PQfreemem(message);
  return options;
}

bool is_secret(const PQconninfoOption& option) { return std::string_view(option.dispchar) == "*"; }

std::string quoted(std::string_view value) {
  std::string out = "'";
  for (const char c : value) {
    if (c == '\'' || c == '\\') out += '\\';
    out += c;
  }
  return out + "'";
}

}  // namespace

bool is_conninfo(const std::string& text) { return text.find('\0') == std::string::npos && parsed(text) != nullptr; }

std::string without_password(const std::string& text) {
  const Options options = parsed(text);
  if (!options) return "";
  bool hidden = false;
  std::string left;
  for (const PQconninfoOption* option = options.get(); option->keyword; ++option) {
    if (!option->val) continue;
    if (is_secret(*option)) {
      hidden = true;
    } else {
      left += (left.empty() ? "" : " ") + std::string(option->keyword) + "=" + quoted(option->val);
    }
  }
  return hidden ? left : text;
}

}  // namespace meshgauge::server::store
