// Faces of any number of corners as triangles: the one way for OBJ, PLY and OFF.
//
// A reader hands its faces to Faces, which keeps triangles that stand for them, n - 2 for a face of n corners: its
// vertices may still be to come. When all is read, split_polygons() puts the face's own triangles in their place.
//
// How a face is split: seen along the axis in which its area is largest (to leave out a coordinate rounds nothing). A
// convex face is a fan from its first corner; any other has its ears clipped (ear_clipping.h), so that a planar face
// that does not cross itself becomes exactly its surface. Corners on one line, repeated corners and spikes belong to
// the outline, and so to the surface, as triangles without area.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "api/formats/fan.h"
#include "api/formats/source.h"

namespace meshgauge::api {

// Faces of equally many corners, more than three, whose triangles follow each other.
struct FaceRun {
  std::size_t first_triangle = 0;
  std::size_t corners = 0;
  std::size_t faces = 0;
};

// Takes the corners of one face after another: begin(), add() for each corner, end().
class Faces {
 public:
  explicit Faces(std::vector<Triangle>& triangles) : triangles_(triangles), fan_(triangles) {}

  void begin() { fan_.begin(); }
  void add(std::uint32_t corner) { fan_.add(corner); }
  void end() {
    if (fan_.corners() > 3) add_to_runs();
  }

  std::size_t corners() const { return fan_.corners(); }  // of the face begun
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

// Splits the faces, whose vertices are all in the mesh, and fills read.notes.polygons. A face of very many corners may
// need more work than is allowed for one file: kSplitSteps and kStepsPerCorner for each corner; the Error names it.
Result<Done> split_polygons(const Source& source, const std::vector<FaceRun>& runs, ReadMesh& read);

inline constexpr std::size_t kSplitSteps = std::size_t{1} << 28;
inline constexpr std::size_t kStepsPerCorner = 32;
inline constexpr std::size_t kMeasureSteps = std::size_t{1} << 26;  // for deviations; with none left, D1 bounds them

// Above it a face counts as not planar: its thickness along its normal over its largest coordinate c. Six significant
// digits round each coordinate by at most 5e-6 c, which moves a corner along a normal by up to sqrt(3) times that, and
// two corners apart by twice as much: 1.8e-5 c. Rounding to binary32 moves them by far less.
inline constexpr double kPlanarThickness = 0x1p-15;

}  // namespace meshgauge::api
