#include "server/main/settings_file.h"

#include <charconv>
#include <set>
#include <vector>

#include "api/base/refused.h"
#include "api/base/whole_file.h"
#include "server/http/text.h"
#include "server/store/conninfo.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 20;
constexpr std::string_view kEscapes = "\"\\bfnrt";
constexpr std::string_view kEscaped = "\"\\\b\f\n\r\t";

bool at_end(std::string_view rest) { return trimmed(rest).empty() || trimmed(rest).starts_with('#'); }

Result<Done> parse_value(std::string_view text, std::string& field) {
  const auto malformed = refused("must be a text in double quotes");
  if (!text.starts_with('"')) return malformed;
  std::string value;
  std::size_t i = 1;
  for (; i < text.size() && text[i] != '"'; ++i) {
    if (text[i] != '\\') {
      value += text[i];
      continue;
    }
    const std::size_t escape = ++i < text.size() ? kEscapes.find(text[i]) : std::string_view::npos;
    if (escape == std::string_view::npos) return refused("has an unknown escape; known: \\\" \\\\ \\b \\f \\n \\r \\t");
    value += kEscaped[escape];
  }
  if (i >= text.size() || !at_end(text.substr(i + 1))) return malformed;
  field = std::move(value);
  return Done{};
}

Result<Done> parse_value(std::string_view text, std::uint64_t& field) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !at_end({end, static_cast<std::size_t>(text.data() + text.size() - end)})) {
    return refused("must be a whole number, 0 or more, without quotes");
  }
  field = value;
  return Done{};
}

Result<Done> parse_value(std::string_view text, bool& field) {
  const std::string_view word = text.substr(0, text.find_first_of(" \t#"));
  if ((word != "true" && word != "false") || !at_end(text.substr(word.size()))) return refused("must be true or false");
  field = word == "true";
  return Done{};
}

Result<Done> set(std::string_view name, std::string_view text, Settings& settings) {
  Result<Done> done = refused("is not a setting");
  for_each_setting(settings, [&](const SettingText& setting, auto& field) {
    if (setting.name == name) done = parse_value(text, field);
  });
  return done;
}

std::string printed(const std::string& value) {
  std::string out = "\"";
  for (const char c : value) {
    const std::size_t escape = kEscaped.find(c);
    out += escape == std::string_view::npos ? std::string(1, c) : std::string{'\\', kEscapes[escape]};
  }
  return out + '"';
}

std::string printed(std::uint64_t value) { return std::to_string(value); }
std::string printed(bool value) { return value ? "true" : "false"; }

}  // namespace

Result<Done> apply_settings(std::string_view text, Settings& settings) {
  std::set<std::string_view> seen;
  for (std::size_t number = 1; !text.empty(); ++number) {
    std::string_view line = next(text, "\n");
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (at_end(line)) continue;
    const std::string at = "line " + std::to_string(number) + ": ";
    if (line.find('=') == std::string_view::npos) return refused(at + "must be 'name = value'");
    const std::string_view name = trimmed(next(line, "="));
    if (!seen.insert(name).second) return refused(at + "'" + std::string(name) + "' is set twice");
    if (const auto ok = set(name, trimmed(line), settings); !ok) {
      return refused(at + "'" + std::string(name) + "' " + ok.error().message);
    }
  }
  return Done{};
}

Result<Done> load_settings(const std::string& file, Settings& settings) {
  const auto failed = [&](const std::string& why) { return refused("--config '" + file + "': " + why); };
  const auto text = api::read_text_file(file, kMaxFileBytes);
  if (!text) return failed(text.error().message);
  const auto ok = apply_settings(*text, settings);
  return ok ? ok : failed(ok.error().message);
}

std::string to_text(Settings asked, Settings in_force) {
  const std::string database = store::without_password(asked.database);
  const bool hidden = database != asked.database;
  asked.database = in_force.database = database;
  std::vector<std::string> forced;
  for_each_setting(in_force, [&](const SettingText&, const auto& field) { forced.push_back(printed(field)); });
  std::string text;
  std::size_t i = 0;
  for_each_setting(asked, [&](const SettingText& setting, const auto& field) {
    const std::string value = printed(field);
    text += std::string("# ") + setting.help + "\n" + setting.name + " = " + value;
    if (forced[i] != value) text += "  # here: " + forced[i];
    if (hidden && setting.name == std::string_view("database")) text += "  # a password is set, but not shown";
    text += '\n';
    ++i;
  });
  return text;
}

}  // namespace meshgauge::server
