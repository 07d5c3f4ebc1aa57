// Pictures of a gate's meshes: views coloured by distance, and a histogram.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/map/colour_map.h"
#include "check/html/camera.h"
#include "check/html/histogram.h"
#include "check/outcome.h"
#include "check/run/meshes.h"
#include "engine/control.h"
#include "engine/thread_pool.h"
#include "engine/tree/prepared.h"

namespace meshgauge::check {

struct Shot {
  std::vector<std::byte> png;
  Camera camera;
  std::optional<Seen> from;  // the witness, perhaps outside the picture; nullopt: there is none on the meshes
  std::optional<Seen> to;    // its nearest point on the other mesh; set with `from`
  bool hidden = false;       // the part covers the end of the witness that is on it
  bool cut = false;          // the part is cut open in front of the witness
  double close_up = 0;       // size of the close-up around `from`, as a share of this picture's; 0: there is none
};

// One mesh, coloured by its distance to the other.
struct Surface {
  bool candidate = true;
  api::ColourScale scale;
  Shot whole;
  std::optional<Shot> close_up;
  Histogram histogram;
};

struct GatePicture {
  std::vector<Surface> surfaces;   // surfaces that the gate's direction measures, the candidate first
  std::string missing;             // why there is no picture; empty if there is one
  bool left_out = false;           // true: other gates need a picture more
  std::vector<std::byte> strip{};  // a PNG of strip_of(), of at most kStripBytes
};

// What is drawn of a gate.
struct Drawn {
  bool surfaces = true;  // GatePicture::surfaces
  bool strip = false;    // GatePicture::strip
};

// Makes a gate's pictures. A failed or undecided gate gets large views of each measured surface and close-ups of the
// witness, a passed gate one small view. Distances are computed for each pixel and not certified. Memory: both trees,
// unless the meshes have them, and the samples of one view. Precondition: the outcome is measured. Returns no picture
// if `control`, which is polled, says to stop. Deterministic for any size of the pool.
GatePicture make_picture(const Prepared& candidate, const Prepared& baseline, const GateOutcome& outcome,
                         ThreadPool& pool, Control& control, const Drawn& drawn = {});

// Makes the pictures from the files of the outcome, in one turn of `meshes`, and ends that turn. If a file is gone or
// has changed since the measurement, `missing` says so.
GatePicture picture_of(const GateOutcome& outcome, Meshes& meshes, ThreadPool& pool, Control& control,
                       const Drawn& drawn = {});

}  // namespace meshgauge::check
