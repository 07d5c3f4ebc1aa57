// What the kinds of fronts (engine/fast/front.h) share: a lower bound, and leaving out what is within the tolerance of
// it.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/fast/front.h"
#include "engine/mesh/mesh_index.h"
#include "engine/rounding.h"
#include "engine/tree/nearest.h"
#include "engine/tree/vicinity.h"

namespace meshgauge {

// One object for each direction.
class FrontWork {
 public:
  // The arguments of take_front().
  FrontWork(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, const Slack& slack, double known,
            Control& control, ThreadPool& pool);
  FrontWork(const FrontWork&) = delete;
  FrontWork& operator=(const FrontWork&) = delete;

  double lower() const { return lower_; }

 protected:
  ~FrontWork() = default;

  // More than one part of so many of a mesh is not worth the front.
  static constexpr std::size_t kMostLeft = 2;
  static constexpr std::uint32_t kBlock = 64;  // triangles
  // A reach is above the bound that it serves, so that it never decides.
  static constexpr double kWider = 1 + 0x1p-20;

  // A point whose distance from B is wanted.
  struct Query {
    Vec3 point;              // in the frame
    double upper;            // of its distance
    std::uint32_t vertex;    // of A: the point
    std::uint32_t triangle;  // of A: it has the vertex
  };

  // The bound below which triangles are left out, for the lower bound of now.
  double limit() const { return goal_.cull_within_tolerance(lower_, slack_); }

  // Finds the points of B nearest to the queries and raises the lower bound. Adds the largest distance of a found point
  // from B to `off`. `declined`: too much of B is near.
  FrontEnd measure(std::span<const Query> queries, std::vector<Vec3>& nearest_points, double& off);

  // Leaves out the triangles t of A with upper_sq(t) within the limit. The search needs the candidate for the witness:
  // of a candidate within the limit it gets the measured vertex alone. `off`: what a bound may be too small by, beside
  // the slack of a distance.
  template <class UpperSq>
  FrontEnd leave_out(const UpperSq& upper_sq, double off) {
    const double most_out = limit() - off, most_out_sq = most_out * most_out;
    if (upper_sq(candidate_) > most_out_sq) vertex_.reset();
    const std::size_t count = from_.triangles.size();
    std::vector<std::uint32_t> rest;
    double left_out_sq = 0, most_sq = 0;
    const auto see = [&](std::uint32_t t, double sq) {
      const bool is_left_out = sq <= most_out_sq && (t != candidate_ || vertex_);
      if (is_left_out) left_out_sq = std::max(left_out_sq, sq);
      if (is_left_out && t != candidate_) return;
      rest.push_back(t);
      most_sq = std::max(most_sq, sq);
    };
    const auto see_block = [&](std::uint32_t block) {  // of most blocks all triangles are left out
      const std::uint32_t begin = block * kBlock;
      const auto end = static_cast<std::uint32_t>(std::min<std::size_t>(begin + kBlock, count));
      std::array<double, kBlock> sq;
      double most = 0;
      for (std::uint32_t t = begin; t < end; ++t) most = std::max(most, sq[t - begin] = upper_sq(t));
      if (most <= most_out_sq && block != candidate_ / kBlock) {
        left_out_sq = std::max(left_out_sq, most);
      } else {
        for (std::uint32_t t = begin; t < end; ++t) see(t, sq[t - begin]);
      }
    };
    const bool done = each_unless(interrupted_, (count + kBlock - 1) / kBlock, see_block, 128);
    if (!done) return FrontEnd::interrupted;
    if (!(most_out > 0) || kMostLeft * rest.size() > from_.triangles.size()) return FrontEnd::declined;
    return keep(rest, std::sqrt(left_out_sq) + off, kWider * std::sqrt(most_sq) + off + rounding::kDistanceSlack);
  }

  Vec3 point(std::uint32_t vertex) const { return pair_.frame.to_frame(from_.positions[vertex]); }
  Box box_of(const MeasuredMesh& mesh) const;

  const MeasuredPair& pair_;
  MeasuredDirection& direction_;
  const Goal& goal_;
  const Slack slack_;
  double lower_;
  Control& control_;
  ThreadPool& pool_;
  const MeshView from_;
  const MeshView to_;
  const Interrupted interrupted_ = [this] { return control_.check() != Interruption::none; };
  std::uint32_t candidate_ = 0;          // a triangle of A, with the vertex that lower_ is the distance of
  std::optional<std::uint32_t> vertex_;  // that vertex; nullopt: none has raised lower_

 private:
  // Sets what the direction needs to search these triangles of A, whose points have distances of at most `reach`.
  FrontEnd keep(const std::vector<std::uint32_t>& rest, double left_out, double reach);
  const MeshCells* cells_of_b();  // null: interrupted

  std::optional<MeshCells> cells_of_b_;
};

}  // namespace meshgauge
