// The target of a request, and the value of Host: the same text as both. Asserted: the parser accepts exactly what
// POSIX regular expressions, written from the grammars of RFC 9112 and RFC 3986, match; it names the same form; and
// what it takes apart is the text again when it is put together.
#include "server/http/target.h"

#include <regex.h>

#include <string>
#include <string_view>

#include "server/http/head.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using server::Authority;
using server::RequestTarget;

class Grammar {
 public:
  explicit Grammar(const std::string& expression) {
    require(::regcomp(&compiled_, ("^(" + expression + ")$").c_str(), REG_EXTENDED | REG_NOSUB) == 0, "an expression",
            expression);
  }
  ~Grammar() { ::regfree(&compiled_); }
  Grammar(const Grammar&) = delete;
  Grammar& operator=(const Grammar&) = delete;

  bool matches(std::string_view text) const {
    if (text.find('\0') != std::string_view::npos) return false;  // of no grammar, and the end of a text to regexec()
    return ::regexec(&compiled_, std::string(text).c_str(), 0, nullptr, 0) == 0;
  }

 private:
  regex_t compiled_{};
};

const std::string kEncoded = "%[0-9A-Fa-f][0-9A-Fa-f]";
const std::string kRegName = "([A-Za-z0-9._~!$&'()*+,;=-]|" + kEncoded + ")*";
const std::string kPathChar = "([A-Za-z0-9._~!$&'()*+,;=:@-]|" + kEncoded + ")";
const std::string kQuery = "([A-Za-z0-9._~!$&'()*+,;=:@/?-]|" + kEncoded + ")*";
const std::string kOctet = "(25[0-5]|2[0-4][0-9]|1[0-9][0-9]|[1-9]?[0-9])";
const std::string kIpv4 = "(" + kOctet + "\\." + kOctet + "\\." + kOctet + "\\." + kOctet + ")";
const std::string kGroup = "[0-9A-Fa-f]{1,4}";
const std::string kLastTwo = "(" + kGroup + ":" + kGroup + "|" + kIpv4 + ")";

// Up to `count` groups before the "::" that stands for the missing ones.
std::string elided(int count) {
  const std::string more = count > 1 ? "(" + kGroup + ":){0," + std::to_string(count - 1) + "}" : "";
  return "(" + more + kGroup + ")?::";
}

// So many groups, each with its colon.
std::string groups(int count) { return "(" + kGroup + ":){" + std::to_string(count) + "}"; }

const std::string kIpv6 = "(" + groups(6) + kLastTwo + "|::" + groups(5) + kLastTwo + "|" + elided(1) + groups(4) +
                          kLastTwo + "|" + elided(2) + groups(3) + kLastTwo + "|" + elided(3) + groups(2) + kLastTwo +
                          "|" + elided(4) + groups(1) + kLastTwo + "|" + elided(5) + kLastTwo + "|" + elided(6) +
                          kGroup + "|" + elided(7) + ")";
const std::string kHost = "(\\[" + kIpv6 + "\\]|" + kRegName + ")";
// A host of http has at least one character.
const std::string kSomeHost =
    "(\\[" + kIpv6 + "\\]|(" + kRegName + "[A-Za-z0-9._~!$&'()*+,;=-]|" + kRegName + kEncoded + "))";
const std::string kPaths = "(/" + kPathChar + "*)";

struct Grammars {
  const Grammar origin{kPaths + "+(\\?" + kQuery + ")?"};
  const Grammar absolute{"[Hh][Tt][Tt][Pp][Ss]?://" + kSomeHost + "(:[0-9]*)?" + kPaths + "*(\\?" + kQuery + ")?"};
  const Grammar authority{kSomeHost + ":[0-9]+"};
  const Grammar asterisk{"\\*"};
  const Grammar host{kHost + "(:[0-9]*)?"};
  const Grammar ipv4{kIpv4 + "(:[0-9]*)?"};
  const Grammar ipv6{"\\[" + kIpv6 + "\\](:[0-9]*)?"};
};

const Grammar& of_form(const Grammars& all, RequestTarget::Form form) {
  switch (form) {
    case RequestTarget::Form::origin:
      return all.origin;
    case RequestTarget::Form::absolute:
      return all.absolute;
    case RequestTarget::Form::authority:
      return all.authority;
    case RequestTarget::Form::asterisk:
      break;
  }
  return all.asterisk;
}

// Whether the parts follow one another to the end of the text, with nothing between them that is not theirs.
bool is_whole(std::string_view text, const RequestTarget& target) {
  if (target.form == RequestTarget::Form::absolute) text.remove_prefix(text.find("://") + 3);
  if (!text.starts_with(target.authority)) return false;
  text.remove_prefix(target.authority.size());
  if (text.starts_with(target.path)) text.remove_prefix(target.path.size());  // not the slash of "http://host"
  return target.query.empty() ? text.empty() || text == "?" : text == "?" + std::string(target.query);
}

void require_same_target(const Grammars& all, std::string_view text) {
  const auto target = server::parse_target(text);
  int forms = 0;
  for (const Grammar* grammar : {&all.origin, &all.absolute, &all.authority, &all.asterisk}) {
    forms += grammar->matches(text) ? 1 : 0;
  }
  require(forms <= 1, "a target has one form", text);
  require(target.has_value() == (forms == 1), "the parser accepts what the grammar of targets does", text);
  if (!target) return;
  require(of_form(all, target->form).matches(text), "the parser names the form", text);
  require(is_whole(text, *target), "nothing of a target is lost", text);
  require(target->authority.find_first_of("/?#@") == std::string_view::npos, "an authority is host and port", text);
}

void require_same_host(const Grammars& all, std::string_view text) {
  const auto authority = server::parse_authority(text);
  require(authority.has_value() == all.host.matches(text), "the parser accepts what the grammar of hosts does", text);
  if (!authority) return;
  require((authority->kind == Authority::Kind::ipv4) == all.ipv4.matches(text), "an address of four numbers", text);
  require((authority->kind == Authority::Kind::ipv6) == all.ipv6.matches(text), "an address in brackets", text);
  require(text.starts_with(authority->host), "the host comes first", text);
  const std::string_view rest = text.substr(authority->host.size());
  require(rest.empty() ? authority->port.empty() : rest == ":" + std::string(authority->port), "then the port", text);
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(target) {
  using namespace meshgauge;
  static const fuzz::Grammars grammars{};
  const auto text = fuzz::text_of(data, size).substr(0, server::kMaxTargetBytes);
  fuzz::require_same_target(grammars, text);
  fuzz::require_same_host(grammars, text);
  return 0;
}
