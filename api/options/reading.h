// The values of a request's document: reads each, and collects what is wrong with them.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/base/units.h"
#include "api/options/names.h"
#include "api/options/quantity.h"
#include "api/options/surface.h"

namespace meshgauge::api {

using JsonValue = nlohmann::json;

struct RequestMistake {
  std::string pointer;  // JSON pointer in the document
  std::string message;  // a sentence without full stop, which names the place
  bool of_key = false;  // about the member's key, not its value
};

// One document while it is read. Each function reads the value at the JSON pointer `at`, or adds a mistake.
class Reading {
 public:
  explicit Reading(const Surface& its_surface) : surface(its_surface) {}

  const Surface& surface;
  std::vector<RequestMistake> mistakes;

  // The largest number of mistakes that are told; more are counted.
  static constexpr std::size_t kMost = 32;
  void add(const std::string& at, std::string sentence, bool of_key = false);
  // Returns the mistakes, and how many more there are. Call it once, at the end.
  std::vector<RequestMistake> told();
  void refuse(const std::string& at, const std::string& what) { add(at, surface.name(at) + " " + what); }
  std::string shown(const JsonValue& value) const;  // for "must be ..., not ..."

  std::optional<double> number(const JsonValue& value, const Range& range, const std::string& at);
  std::optional<bool> boolean(const JsonValue& value, const std::string& at);
  std::optional<std::string> text(const JsonValue& value, const std::string& at);

  template <class Enum, std::size_t N>
  std::optional<Enum> name(const Name<Enum> (&table)[N], const JsonValue& value, const std::string& at) {
    if (value.is_string()) {
      if (const auto found = value_of(table, value.get_ref<const std::string&>())) return found;
    }
    std::vector<std::string_view> known;
    for (const auto& row : table) known.push_back(row.text);
    no_name(value, known, at);
    return std::nullopt;
  }

  struct Member {
    std::string_view key;
    std::function<void(const JsonValue& value, const std::string& at)> read;
  };
  // Members that are read into `out`, which a mistake leaves as it is. Borrow it.
  template <class Out>
  Member number_into(std::string_view key, Out& out, const Range& range) {
    return into(key, out,
                [this, range](const JsonValue& value, const std::string& at) { return number(value, range, at); });
  }
  template <class Out>
  Member boolean_into(std::string_view key, Out& out) {
    return into(key, out, [this](const JsonValue& value, const std::string& at) { return boolean(value, at); });
  }
  template <class Out>
  Member limit_into(std::string_view key, Out& out) {
    return into(key, out, [this](const JsonValue& value, const std::string& at) { return limit(value, at); });
  }
  // Reads the members that there are, in this order. False: it is no object.
  bool members(const JsonValue& value, std::span<const Member> known, const std::string& at);
  // As members(), of an object that has at least one. `or_else`: what it may be as well, "a whole number, or ".
  bool some_members(const JsonValue& value, std::span<const Member> known, const std::string& at,
                    std::string_view or_else = "");

  // Reads an array of `least` to `most` values. False: it is none.
  bool elements(const JsonValue& value, std::size_t least, std::size_t most, std::string_view of,
                const std::function<void(const JsonValue& value, const std::string& at)>& read, const std::string& at);

  enum class Sign { none, minus, plus };  // what may stand before the number, and is kept
  // Reads a length that is a limit: a number, "0.05 mm", or "0.5 %" of the diagonal as 0.005.
  std::optional<double> limit(const JsonValue& value, const std::string& at, Sign sign = Sign::none) {
    return length(value, at, sign, true);
  }
  // Reads a length in the unit of the limits that is none, and no share of the diagonal.
  std::optional<double> length(const JsonValue& value, const std::string& at) {
    return length(value, at, Sign::none, false);
  }
  // Reads a share, 0.01 or "1 %", as a fraction of 1. `what`: of what, for the message.
  std::optional<double> share(const JsonValue& value, std::string_view of, const std::string& at);

  // The unit of all limits, and of the lengths beside them.
  struct LimitUnit {
    std::optional<LengthUnit> unit;  // nullopt: none is given
    bool of_diagonal = false;        // of mesh b
  };
  // Returns the unit in which the limits and lengths are that were read, and refuses those in another. `declared`: the
  // unit of bare numbers, which all others must have as well; in words "gate.units is 'mm'".
  LimitUnit unit_of_limits(const std::optional<LimitUnit>& declared, const std::string& declared_words);

 private:
  struct Limit {
    std::string at;
    LimitUnit unit;
    bool is_bare = false;
    bool is_zero = false;
    bool or_share = true;  // it may be a share of the diagonal
  };

  template <class Out, class Read>
  static Member into(std::string_view key, Out& out, const Read& read) {
    return {key, [read, &out](const JsonValue& value, const std::string& at) {
              if (const auto found = read(value, at)) out = static_cast<Out>(*found);
            }};
  }

  std::optional<double> length(const JsonValue& value, const std::string& at, Sign sign, bool or_share);
  void no_name(const JsonValue& value, std::span<const std::string_view> known, const std::string& at);
  void unknown(const std::string& at, const std::string& key, std::span<const Member> known);
  static std::string in_words(const Limit& limit);

  std::size_t more_ = 0;  // mistakes that are not told
  std::vector<Limit> limits_;
};

}  // namespace meshgauge::api
