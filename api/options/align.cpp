#include <array>
#include <utility>

#include <Eigen/LU>

#include "api/base/figures.h"
#include "api/base/json_filter.h"
#include "api/options/parts.h"

namespace meshgauge::api {
namespace {

using Numbers = std::array<double, 16>;

constexpr Range kOverlapRange{0.1, 1};
constexpr Range kEntryRange{-kMaxCoordinate, kMaxCoordinate};

std::optional<Numbers> read_numbers(const JsonValue& value, const std::string& at, Reading& reading) {
  Numbers numbers{};
  std::size_t count = 0;
  const auto read = [&](const JsonValue& entry, const std::string& place) {
    const auto number = reading.number(entry, kEntryRange, place);
    if (number) numbers[count++] = *number;
  };
  reading.elements(value, numbers.size(), numbers.size(), "numbers", read, at);
  return count == numbers.size() ? std::optional(numbers) : std::nullopt;
}

// `rows`: row by row.
std::optional<RigidMotion> motion_of(const Numbers& rows, const std::string& at, Reading& reading) {
  if (rows[12] != 0 || rows[13] != 0 || rows[14] != 0 || rows[15] != 1) {
    const bool other = rows[3] == 0 && rows[7] == 0 && rows[11] == 0;
    reading.refuse(at, "must end with the row 0 0 0 1, not " + shortest(rows[12]) + " " + shortest(rows[13]) + " " +
                           shortest(rows[14]) + " " + shortest(rows[15]) +
                           (other ? "; as it is written, it has the other order of row_major and column_major" : ""));
    return std::nullopt;
  }
  RigidMotion motion;
  for (int i = 0; i < 3; ++i) {
    const double* const row = rows.data() + 4 * i;
    motion.rotation.row(i) = Eigen::RowVector3d(row[0], row[1], row[2]);
    motion.translation[i] = row[3];
  }
  const double off = off_orthonormal(motion.rotation);
  if (!(off <= kMostOffOrthonormal)) {
    reading.refuse(at, "must be rigid, but its 3x3 part R scales or shears: R^T R is off the identity by " +
                           shortest(off) + " (limit " + shortest(kMostOffOrthonormal) +
                           "; write at least six decimals)");
    return std::nullopt;
  }
  if (motion.rotation.determinant() < 0) {
    reading.refuse(at, "must be rigid, but it mirrors: its determinant is -1");
    return std::nullopt;
  }
  if (off > RigidMotion::kOrthonormal) motion.rotation = nearest_rotation(motion.rotation);
  return motion;
}

std::optional<AlignOptions> read_members(const JsonValue& value, const std::string& at, Reading& reading) {
  AlignOptions options;
  options.fit = !value.contains("transform");
  const std::size_t mistakes = reading.mistakes.size();
  std::string needs_fit;
  const auto transform = [&](const JsonValue& v, const std::string& place) {
    if (const auto motion = read_transform(v, place, reading)) options.start = *motion;
  };
  const auto principal_axes = [&](const JsonValue& v, const std::string& place) {
    options.principal_axes = reading.boolean(v, place).value_or(false);
    if (options.principal_axes) needs_fit = place;
  };
  const auto overlap = [&](const JsonValue& v, const std::string& place) {
    options.overlap = reading.number(v, kOverlapRange, place).value_or(1);
    needs_fit = place;
  };
  const Reading::Member members[] = {{"transform", transform},
                                     reading.boolean_into("fit", options.fit),
                                     {"principal_axes", principal_axes},
                                     {"overlap", overlap}};
  reading.members(value, members, at);
  if (reading.mistakes.size() > mistakes) return std::nullopt;
  if (!options.fit && !value.contains("transform"))
    reading.refuse(at + "/fit", "is false, so " + reading.surface.name(at) + " needs a transform");
  else if (!options.fit && !needs_fit.empty())
    reading.refuse(needs_fit, "is for a best fit: with a transform, add \"fit\": true");
  return options;
}

}  // namespace

std::optional<RigidMotion> read_transform(const JsonValue& value, const std::string& at, Reading& reading) {
  const bool is_one = value.is_object() && value.size() == 1;
  const std::string order = is_one ? value.begin().key() : "";
  if (order != "row_major" && order != "column_major") {
    reading.refuse(at, "must be " + std::string(reading.surface.object) +
                           " with the 16 numbers of a 4x4 matrix as row_major or as column_major, not " +
                           (is_one ? shown_text(order) : reading.shown(value)));
    return std::nullopt;
  }
  auto numbers = read_numbers(value.front(), at + "/" + order, reading);
  if (!numbers) return std::nullopt;
  if (order == "column_major") {
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t k = 0; k < i; ++k) std::swap((*numbers)[4 * i + k], (*numbers)[4 * k + i]);
    }
  }
  return motion_of(*numbers, at + "/" + order, reading);
}

std::optional<AlignOptions> read_align(const JsonValue& value, const std::string& at, Reading& reading) {
  if (value == "none") return std::nullopt;
  if (value == "rigid") return AlignOptions();
  if (value.is_object()) return read_members(value, at, reading);
  reading.refuse(at, "must be none, rigid, or " + std::string(reading.surface.object) +
                         " of transform, fit, principal_axes, overlap; not " + reading.shown(value));
  return std::nullopt;
}

}  // namespace meshgauge::api
