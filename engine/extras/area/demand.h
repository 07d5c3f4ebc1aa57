// What is still too wide of the intervals, and how much of it a part contributes.
#pragma once

#include <algorithm>
#include <vector>

#include "engine/extras/area/enclosure.h"
#include "engine/extras/area/part.h"

namespace meshgauge {

inline double mean_width(const Enclosure& e) { return mean(e.high) - mean_below(e.low); }
inline double square_width(const Enclosure& e) { return mean_square(e.high) - mean_square_below(e.low); }

// Scales of a part's widths, by which they count in tolerances; 0: narrow enough.
struct Demand {
  // The share beyond a limit of distance.
  struct Probe {
    double down, up;
    double scale;
  };
  std::vector<Probe> probes;
  double mean = 0;
  double square = 0;

  bool met() const { return probes.empty() && mean == 0 && square == 0; }

  // Whether a lower function, which is at most the corners' distances, can narrow the part, or show that nothing can.
  // `near`: the slack of its functions, within which a distance may equal a limit.
  bool needs_low(const Part& part, double near) const {
    double farthest = 0;
    for (const Corner& corner : part.corners) farthest = std::max(farthest, corner.distance);
    return mean > 0 || square > 0 ||
           std::any_of(probes.begin(), probes.end(), [&](const Probe& probe) { return farthest + near > probe.up; });
  }

  // The largest of the part's widths in tolerances, times its weight.
  double contribution(const Part& part) const {
    const Enclosure& e = part.enclosure;
    double most_wanted = 0;
    for (const Probe& probe : probes) {
      const double high = share_beyond(e.high, probe.down);
      if (high > 0) most_wanted = std::max(most_wanted, probe.scale * (high - share_beyond(e.low, probe.up)));
    }
    if (mean > 0) most_wanted = std::max(most_wanted, mean * mean_width(e));
    if (square > 0) most_wanted = std::max(most_wanted, square * square_width(e));
    return part.weight * most_wanted;
  }
};

}  // namespace meshgauge
