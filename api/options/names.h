// Names of the engine's enums in JSON and flags. One table per enum: a new value needs one new row.
#pragma once

#include <optional>
#include <string_view>

#include "engine/options.h"
#include "engine/outcome.h"

namespace meshgauge::api {

template <class Enum>
struct Name {
  Enum value;
  std::string_view text;
};

inline constexpr Name<Direction> kDirections[] = {
    {Direction::symmetric, "symmetric"}, {Direction::a_to_b, "a_to_b"}, {Direction::b_to_a, "b_to_a"}};

// As manifests and flags have them, too, where a is the candidate. The first name of a value is shown.
inline constexpr Name<Direction> kDirectionWords[] = {{Direction::symmetric, "symmetric"},
                                                      {Direction::a_to_b, "candidate_to_baseline"},
                                                      {Direction::b_to_a, "baseline_to_candidate"},
                                                      {Direction::a_to_b, "a_to_b"},
                                                      {Direction::b_to_a, "b_to_a"}};

inline constexpr Name<Strategy> kStrategies[] = {{Strategy::automatic, "auto"},
                                                 {Strategy::four_point, "four_point"},
                                                 {Strategy::n_point, "n_point"},
                                                 {Strategy::triangle_set, "triangle_set"}};

inline constexpr Name<Stop> kStops[] = {{Stop::converged, "converged"}, {Stop::gate_decided, "gate_decided"},
                                        {Stop::timeout, "timeout"},     {Stop::cancelled, "cancelled"},
                                        {Stop::budget, "budget"},       {Stop::precision_floor, "precision_floor"}};

inline constexpr Name<Rule> kRules[] = {
    {Rule::absolute, "absolute"}, {Rule::diagonal, "diagonal"}, {Rule::relative, "relative"}};

inline constexpr Name<Weight> kWeights[] = {
    {Weight::area, "area"}, {Weight::length, "length"}, {Weight::points, "points"}};

// Why the narrowing of certified areas ended.
inline constexpr Name<AreaStop> kAreaStops[] = {
    {AreaStop::complete, "complete"}, {AreaStop::precision_floor, "precision_floor"},
    {AreaStop::timeout, "timeout"},   {AreaStop::cancelled, "cancelled"},
    {AreaStop::budget, "budget"},     {AreaStop::no_area, "no_area"}};

// Why a mesh has no sides.
inline constexpr Name<NoSides::Why> kNoSides[] = {
    {NoSides::Why::open, "open"},           {NoSides::Why::non_manifold, "non_manifold"},
    {NoSides::Why::flipped, "flipped"},     {NoSides::Why::inside_out, "inside_out"},
    {NoSides::Why::no_volume, "no_volume"}, {NoSides::Why::part_inside_out, "part_inside_out"}};

// Whether the statistics are complete, or why they are not.
inline constexpr Name<StatisticsStatus> kStatisticsStatuses[] = {{StatisticsStatus::complete, "complete"},
                                                                 {StatisticsStatus::timeout, "timeout"},
                                                                 {StatisticsStatus::cancelled, "cancelled"},
                                                                 {StatisticsStatus::memory, "memory"}};

// Returns the name of a value. Precondition: the table has it.
template <class Enum, std::size_t N>
std::string_view name_of(const Name<Enum> (&table)[N], Enum value) {
  for (const auto& row : table) {
    if (row.value == value) return row.text;
  }
  return "";
}

// Returns the value of a name. nullopt: the table has no such name.
template <class Enum, std::size_t N>
std::optional<Enum> value_of(const Name<Enum> (&table)[N], std::string_view text) {
  for (const auto& row : table) {
    if (row.text == text) return row.value;
  }
  return std::nullopt;
}

}  // namespace meshgauge::api
