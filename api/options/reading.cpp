#include "api/options/reading.h"

#include <algorithm>
#include <string_view>
#include <vector>

#include "api/base/json_filter.h"
#include "api/base/suggestion.h"
#include "api/base/text.h"
#include "api/options/asked_units.h"
#include "api/options/quantity.h"

namespace meshgauge::api {
namespace {

std::string joined(std::span<const Reading::Member> members) {
  std::vector<std::string_view> keys;
  for (const Reading::Member& member : members) keys.push_back(member.key);
  return listed(keys);
}

bool is_sign_before(std::string_view text, Reading::Sign sign) {
  return (sign == Reading::Sign::minus && text.starts_with('-')) ||
         (sign == Reading::Sign::plus && text.starts_with('+'));
}

}  // namespace

void Reading::add(const std::string& at, std::string sentence, bool of_key) {
  if (mistakes.size() < kMost) {
    mistakes.push_back({at, std::move(sentence), of_key});
  } else {
    ++more_;
  }
}

std::vector<RequestMistake> Reading::told() {
  if (more_ > 0) mistakes.push_back({"", "and " + std::to_string(more_) + " more mistakes"});
  return std::move(mistakes);
}

std::string Reading::shown(const JsonValue& value) const {
  if (value.is_null()) return std::string(surface.nothing);
  if (!value.is_structured()) return api::shown(value);
  if (!value.empty() || value.is_array()) return std::string(value.is_array() ? surface.array : surface.object);
  return "an empty " + std::string(surface.object.substr(surface.object.find(' ') + 1));
}

std::optional<double> Reading::number(const JsonValue& value, const Range& range, const std::string& at) {
  if (range.integer ? value.is_number_integer() : value.is_number()) {
    const auto checked = in_range(value.get<double>(), range, surface.name(at));
    if (checked) return *checked;
    add(at, checked.error().message);
  } else {
    const bool is_wide = range.high > 1e300 && range.high < Range{}.high;  // as that of coordinates
    refuse(at, "must be " + (is_wide ? "a number" : described(range)) + ", not " + shown(value));
  }
  return std::nullopt;
}

std::optional<bool> Reading::boolean(const JsonValue& value, const std::string& at) {
  if (value.is_boolean()) return value.get<bool>();
  const bool quoted = value == "true" || value == "false";
  refuse(at, std::string("must be true or false") + (quoted ? ", without quotes" : "") + ", not " + shown(value));
  return std::nullopt;
}

std::optional<std::string> Reading::text(const JsonValue& value, const std::string& at) {
  if (value.is_string()) return value.get<std::string>();
  const bool bare = value.is_number() || value.is_boolean();
  refuse(at, "must be a text, not " + shown(value) + (bare ? ": write it in quotes" : ""));
  return std::nullopt;
}

void Reading::no_name(const JsonValue& value, std::span<const std::string_view> known, const std::string& at) {
  const std::string_view meant =
      value.is_string() ? nearest(value.get_ref<const std::string&>(), known) : std::string_view();
  refuse(at, "must be one of " + listed(known) + ", not " + shown(value) +
                 (meant.empty() ? "" : "; did you mean '" + std::string(meant) + "'?"));
}

void Reading::unknown(const std::string& at, const std::string& key, std::span<const Member> known) {
  if (at == "/shards")
    return add(at,
               "/shards is not an option: the threads of one worker share a comparison; leave it out, or set "
               "/threads");
  std::vector<std::string_view> keys;
  for (const Member& member : known) keys.push_back(member.key);
  const std::string name = surface.bit == Surface::http ? at : key;
  add(at, "unknown " + std::string(surface.option) + " " + shown_text(name) + suggestion(key, keys), true);
}

bool Reading::members(const JsonValue& value, std::span<const Member> known, const std::string& at) {
  if (!value.is_object()) {
    refuse(at, "must be " + std::string(surface.object) + (at.empty() ? "" : " of " + joined(known)) + ", not " +
                   shown(value));
    return false;
  }
  for (const Member& member : known) {
    const auto found = value.find(member.key);
    if (found != value.end()) member.read(*found, at + "/" + std::string(member.key));
  }
  for (const auto& [key, ignored] : value.items()) {
    if (std::ranges::find(known, key, &Member::key) == known.end()) unknown(at + "/" + key, key, known);
  }
  return true;
}

bool Reading::some_members(const JsonValue& value, std::span<const Member> known, const std::string& at,
                           std::string_view or_else) {
  if (value.is_object() && !value.empty()) return members(value, known, at);
  refuse(at, "must be " + std::string(or_else) + std::string(surface.object) + " of at least one of " + joined(known) +
                 ", not " + shown(value));
  return false;
}

bool Reading::elements(const JsonValue& value, std::size_t least, std::size_t most, std::string_view of,
                       const std::function<void(const JsonValue& value, const std::string& at)>& read,
                       const std::string& at) {
  if (!value.is_array() || value.size() < least || value.size() > most) {
    const std::string count =
        least == most ? std::to_string(most) : std::to_string(least) + " to " + std::to_string(most);
    refuse(at, "must be " + std::string(surface.array) + " of " + count + " " + std::string(of) + ", not " +
                   (value.is_array() ? "one of " + std::to_string(value.size()) : shown(value)));
    return false;
  }
  for (std::size_t i = 0; i < value.size(); ++i) read(value[i], at + "/" + std::to_string(i));
  return true;
}

std::optional<double> Reading::length(const JsonValue& value, const std::string& at, Sign sign, bool or_share) {
  if (!value.is_string() && !value.is_number())
    return refuse(at, "must be " + std::string(or_share ? kLengthOrShare : kLength) + ", not " + shown(value)),
           std::nullopt;
  if (!value.is_string()) {
    const Range below{-kMaxDistanceRange.high, 0};
    const auto found = number(value, sign == Sign::minus ? below : kMaxDistanceRange, at);
    if (found) limits_.push_back({at, {}, true, *found == 0, or_share});
    return found;
  }
  const std::string_view text = trimmed(value.get_ref<const std::string&>());
  const bool is_signed = is_sign_before(text, sign);
  const auto found = parse_length(is_signed ? trimmed(text.substr(1)) : text, or_share);
  if (!found) return refuse(at, found.error().message), std::nullopt;
  if (sign == Sign::minus && !is_signed && found->number > 0)
    return refuse(at, "must be 0 or below it, as -0.05 mm: it is how far inside; not " + shown_text(text)),
           std::nullopt;
  const bool is_bare = !found->unit && !found->is_share;
  limits_.push_back({at, {found->unit, found->is_share}, is_bare, found->number == 0, or_share});
  return sign == Sign::minus ? 0 - found->number : found->number;
}

std::optional<double> Reading::share(const JsonValue& value, std::string_view of, const std::string& at) {
  if (value.is_string()) {
    const auto found = parse_share(value.get_ref<const std::string&>(), of);
    if (found) return *found;
    refuse(at, found.error().message);
    return std::nullopt;
  }
  if (!surface.by_hand) return number(value, kShareRange, at);
  refuse(at, "must be a share of " + std::string(of) + " in percent (1 %), not " + shown(value));
  return std::nullopt;
}

std::string Reading::in_words(const Limit& limit) {
  if (limit.unit.of_diagonal) return "is a share of the diagonal";
  return limit.unit.unit ? "is in " + std::string(to_string(*limit.unit.unit)) : "has no unit";
}

// A bare 0 is in every unit.
Reading::LimitUnit Reading::unit_of_limits(const std::optional<LimitUnit>& declared,
                                           const std::string& declared_words) {
  const auto counts = [](const Limit& limit) { return !limit.is_bare || !limit.is_zero; };
  const auto first = std::ranges::find_if(limits_, counts);
  if (first == limits_.end() && !declared) return {};
  const std::string wanted = in_words(declared ? Limit{"", *declared} : *first);
  for (const Limit& limit : limits_) {
    const bool takes_declared = declared && limit.is_bare && (limit.or_share || !declared->of_diagonal);
    if (!counts(limit) || in_words(limit) == wanted || takes_declared) continue;
    const std::string other = declared ? declared_words : surface.name(first->at) + " " + wanted;
    refuse(limit.at, in_words(limit) + ", and " + other + ": a gate is measured in one unit, write both in the same");
  }
  return declared ? *declared : first->unit;
}

}  // namespace meshgauge::api
