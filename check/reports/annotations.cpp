#include "check/reports/reports.h"

#include <algorithm>
#include <string_view>
#include <system_error>
#include <vector>

#include "check/files.h"
#include "check/reports/finding.h"
#include "check/reports/wording.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kShownOfEach = 10;  // GitHub shows no more of a step
constexpr std::size_t kTitleBytes = 200;
constexpr std::size_t kMessageBytes = 4000;
constexpr std::string_view kCommands[] = {"error", "warning", "notice"};

// What GitHub's toolkit escapes in a message, and in the value of a property, which ends at a comma or at "::".
constexpr std::string_view kOfMessage = "%\r\n", kOfProperty = "%\r\n:,";

std::string with_escapes(const std::string& text, std::string_view escaped) {
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    if (escaped.find(c) == std::string_view::npos) {
      out += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    out += {'%', kHex[byte / 16], kHex[byte % 16]};
  }
  return out;
}

// Empty: the gate needs none.
std::string_view command_for(const GateOutcome& outcome, Undecided rule) {
  const Level level = outcome.level(rule);
  if (level == Level::failure) return kCommands[0];
  if (level == Level::warning) return outcome.verdict() == Verdict::fail ? kCommands[1] : kCommands[2];
  return unmeasured_of(outcome).empty() ? std::string_view() : kCommands[2];
}

// The path from `top`, if the file is there.
std::string file_from(const std::filesystem::path& top, const std::filesystem::path& file) {
  std::filesystem::path shown = file.lexically_normal();
  std::error_code failed;
  const auto whole = std::filesystem::absolute(shown, failed).lexically_normal();
  if (!top.empty() && !failed && is_below(whole, top.lexically_normal()))
    shown = whole.lexically_relative(top.lexically_normal());
  return shown_name(shown.generic_string());
}

// "file=gates.yaml,line=7,"; empty for a mistake of the flags.
std::string place_properties(const Gate& gate, const std::filesystem::path& top) {
  if (gate.manifest.empty() && gate.candidate.empty()) return "";
  const Location place = location_of(gate);
  return "file=" + with_escapes(file_from(top, place.file), kOfProperty) + ",line=" + std::to_string(place.line) + ",";
}

std::string annotation_of(const GateOutcome& outcome, std::string_view command, const std::filesystem::path& top) {
  const std::string title = "meshgauge: " + cut_at(shown_name(outcome.gate.name), kTitleBytes);
  const std::string properties = place_properties(outcome.gate, top) + "title=" + with_escapes(title, kOfProperty);
  return "::" + std::string(command) + " " + properties +
         "::" + with_escapes(cut_at(description_of(outcome), kMessageBytes), kOfMessage) + "\n";
}

// An error has measured nothing, so it comes before what fails.
bool is_worse(const GateOutcome* a, const GateOutcome* b) {
  constexpr Verdict kWorstFirst[] = {Verdict::error, Verdict::fail, Verdict::undecided, Verdict::pass};
  const auto rank = [&](const GateOutcome* one) { return std::ranges::find(kWorstFirst, one->verdict()); };
  return rank(a) < rank(b);
}

}  // namespace

std::string to_annotations(const Report& report, const std::filesystem::path& top) {
  std::string text;
  for (const std::string_view command : kCommands) {
    std::vector<const GateOutcome*> wanted;
    for (const GateOutcome& outcome : report.outcomes) {
      if (command_for(outcome, report.undecided) == command) wanted.push_back(&outcome);
    }
    std::ranges::stable_sort(wanted, is_worse);
    const bool are_all = wanted.size() <= kShownOfEach;
    const std::size_t shown = are_all ? wanted.size() : kShownOfEach - 1;
    for (std::size_t i = 0; i < shown; ++i) text += annotation_of(*wanted[i], command, top);
    if (!are_all)
      text += "::" + std::string(command) + " title=meshgauge::" + std::to_string(wanted.size() - shown) +
              " more gates: GitHub shows ten of a step, the reports have all\n";
  }
  return text;
}

}  // namespace meshgauge::check
