// Alignment of the candidate before it is measured: its part of the result, and the mesh in its new pose.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "api/options/write_options.h"
#include "engine/control.h"
#include "engine/extras/align/align.h"
#include "engine/result.h"
#include "engine/tree/prepared.h"

namespace meshgauge::api {

// How the candidate was moved, in the unit of the result.
struct Aligned {
  Alignment found;
  Displacement moved;
};

nlohmann::ordered_json json_of(const Aligned& aligned, const AlignOptions& asked);

// Whether a result document's "alignment" is the answer to these options. Older services write no "start" of a fit.
bool is_alignment_by(const nlohmann::ordered_json& alignment, const AlignOptions& asked);

// Returns the motion of a result document's "alignment"; nullopt: it has none. Error: internal, for one that is no
// motion.
Result<std::optional<RigidMotion>> motion_of(const nlohmann::ordered_json& document);

// Returns `mesh` moved by `motion`; it keeps `mesh` alive. Its Prepared::error() counts the rounding. Errors:
// coordinate_too_large; out_of_time when `control` says to stop.
Result<std::shared_ptr<const Prepared>> moved(const std::shared_ptr<const Prepared>& mesh, const RigidMotion& motion,
                                              const std::string& part, Control& control);

// Aligns `candidate` to `baseline`; both are in the unit of the result. Errors: those of moved(). An interrupted search
// gives out_of_time: nothing is measured in a pose that is not the best found.
Result<Aligned> aligned(const Prepared& candidate, const Prepared& baseline, const AlignOptions& asked,
                        const Options& options, const std::string& part, Control& control);

}  // namespace meshgauge::api
