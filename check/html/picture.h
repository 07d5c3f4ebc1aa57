// What a report shows of a gate's meshes: views coloured by distance, and how the surfaces are distributed over it.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "api/colour_map.h"
#include "check/html/camera.h"
#include "check/html/histogram.h"
#include "check/outcome.h"
#include "check/run/meshes.h"
#include "engine/control.h"
#include "engine/prepared.h"
#include "engine/thread_pool.h"

namespace meshgauge::check {

struct Shot {
  std::vector<std::byte> png;
  Camera camera;
  std::optional<Seen> from;  // the witness, where the camera sees it
  std::optional<Seen> to;
  bool hidden = false;  // the part covers the end of the witness that lies on it
  bool cut = false;     // what covers the witness is left out
  double close_up = 0;  // size of what the close-up shows around `from`, as a share of this picture's; 0: there is none
};

// One of the two meshes, coloured by the distance to the other one.
struct Surface {
  bool candidate = true;
  api::ColourScale scale;
  Shot whole;
  std::optional<Shot> close_up;
  Histogram histogram;
};

struct GatePicture {
  std::vector<Surface> surfaces;  // those that the gate's direction measures, the candidate first
  std::string missing;            // why there is none; empty where there are some
  bool left_out = false;          // there is none because other gates need one more
};

// A failed or undecided gate gets large views of all that is measured from, with close-ups of the witness; one that
// passes gets one small view. Distances are computed here, for each pixel; nothing of it is certified. Memory: the two
// trees, if the meshes do not have them yet, and the samples of one view. Precondition: the outcome is measured.
// When `control` says to stop, which is asked between the passes over a mesh and for each pixel, there is none.
GatePicture make_picture(const Prepared& candidate, const Prepared& baseline, const GateOutcome& outcome,
                         ThreadPool& pool, Control& control);

// The same of the files that `meshes` has or reads, in one of the turns that it was told of; then it is done with them.
// Whatever stands against it, files that are gone or are not those that were measured, is said in `missing`.
GatePicture picture_of(const GateOutcome& outcome, Meshes& meshes, ThreadPool& pool, Control& control);

}  // namespace meshgauge::check
