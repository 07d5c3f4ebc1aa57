// Splits faces of any number of corners into triangles, for OBJ, PLY and OFF.
//
// A reader passes its faces to Faces, which keeps n - 2 placeholder triangles for a face of n corners, since vertices
// may come later in the file. After the last face, split_polygons() replaces the placeholders by the face's triangles.
//
// A face is split as seen along the axis in which its area is largest (leaving out a coordinate rounds nothing). A
// convex face becomes a fan from its first corner; any other face is split by ear clipping (ear_clipping.h), so that a
// planar face that does not cross itself becomes exactly its surface. Corners on one line, repeated corners and spikes
// belong to the outline, and so to the surface, as triangles without area.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/formats/fan.h"
#include "api/formats/source.h"

namespace meshgauge::api {

// Consecutive faces with the same number of corners, more than three.
struct FaceRun {
  std::size_t first_triangle = 0;
  std::size_t corners = 0;
  std::size_t faces = 0;
};

// Takes faces one by one: begin(), add() for each corner, end().
class Faces {
 public:
  explicit Faces(std::vector<Triangle>& triangles) : triangles_(triangles), fan_(triangles) {}

  void begin() { fan_.begin(); }
  void add(std::uint32_t corner) { fan_.add(corner); }
  void end() {
    if (fan_.corners() > 3) add_to_runs();
  }

  std::size_t corners() const { return fan_.corners(); }  // corners of the current face so far
  const std::vector<FaceRun>& runs() const { return runs_; }

 private:
  void add_to_runs() {
    const std::size_t corners = fan_.corners(), first = triangles_.size() - (corners - 2);
    if (!runs_.empty()) {
      FaceRun& last = runs_.back();
      if (last.corners == corners && last.first_triangle + last.faces * (corners - 2) == first) {
        ++last.faces;
        return;
      }
    }
    runs_.push_back({first, corners, 1});
  }

  std::vector<Triangle>& triangles_;
  Fan fan_;
  std::vector<FaceRun> runs_;
};

// Splits the faces and fills read.notes.polygons. Precondition: all their vertices are in the mesh. Error: too_large,
// naming the face at which the file's budget is spent: kSplitSteps + kStepsPerCorner * corners.
Result<Done> split_polygons(const Source& source, const std::vector<FaceRun>& runs, ReadMesh& read);

inline constexpr std::size_t kSplitSteps = std::size_t{1} << 28;
inline constexpr std::size_t kStepsPerCorner = 32;
inline constexpr std::size_t kMeasureSteps = std::size_t{1} << 26;  // for deviations; once spent, D1 bounds them

// A face is not planar when its thickness along its normal exceeds this times its largest coordinate c. Six significant
// digits round each coordinate by at most 5e-6 c, which moves a corner along a normal by up to sqrt(3) times that, and
// two corners apart by twice as much: 1.8e-5 c. Rounding to binary32 moves them by far less.
inline constexpr double kPlanarThickness = 0x1p-15;

}  // namespace meshgauge::api
