// Splits into triangles: faces of any number of corners, for OBJ, PLY and OFF; fans and strips, for PLY and glTF.
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

#include "api/formats/file/source.h"
#include "engine/mesh.h"

namespace meshgauge::api {

// Takes the corners of polygons one by one and appends their fan triangulation: (0 1 2), (0 2 3), ...
class Fan {
 public:
  explicit Fan(std::vector<Triangle>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }

  void add(std::uint32_t corner) {
    if (corners_ == 0) first_ = corner;
    if (corners_ >= 2) triangles_.push_back({first_, previous_, corner});
    previous_ = corner;
    ++corners_;
  }

  std::size_t corners() const { return corners_; }

 private:
  std::vector<Triangle>& triangles_;
  std::size_t corners_ = 0;
  std::uint32_t first_ = 0;
  std::uint32_t previous_ = 0;
};

// Takes the corners of triangle strips one by one. Every second triangle is reversed, so that all face the same way. A
// triangle with a repeated corner joins two strips written as one; it is left out, since the segment that it spans is
// not part of the surface.
class Strip {
 public:
  explicit Strip(std::vector<Triangle>& triangles) : triangles_(triangles) {}

  void begin() { corners_ = 0; }

  void add(std::uint32_t corner) {
    if (corners_ >= 2) add_triangle(corner);
    before_ = previous_;
    previous_ = corner;
    ++corners_;
  }

  std::size_t corners() const { return corners_; }
  std::size_t joins() const { return joins_; }  // triangles left out, in all strips so far

 private:
  void add_triangle(std::uint32_t corner) {
    if (before_ == previous_ || previous_ == corner || before_ == corner) {
      ++joins_;
    } else if (corners_ % 2 == 0) {
      triangles_.push_back({before_, previous_, corner});
    } else {
      triangles_.push_back({before_, corner, previous_});
    }
  }

  std::vector<Triangle>& triangles_;
  std::size_t corners_ = 0;
  std::size_t joins_ = 0;
  std::uint32_t before_ = 0;
  std::uint32_t previous_ = 0;
};

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
