#include "engine/fast/front_work.h"

namespace meshgauge {

FrontWork::FrontWork(const MeasuredPair& pair, MeasuredDirection& direction, const Goal& goal, const Slack& slack,
                     double known, Control& control, ThreadPool& pool)
    : pair_(pair),
      direction_(direction),
      goal_(goal),
      slack_(slack),
      lower_(known),
      control_(control),
      pool_(pool),
      from_(direction.from.given()),
      to_(direction.to.given()) {}

FrontEnd FrontWork::measure(std::span<const Query> queries, std::vector<Vec3>& nearest_points, double& off) {
  const MeshCells* cells = cells_of_b();
  if (!cells) return FrontEnd::interrupted;
  Vicinity vicinity(*cells);
  for (const Query& query : queries) vicinity.add(Box{query.point, query.point}, kWider * query.upper);
  const auto near = vicinity.triangles(interrupted_);
  if (!near) return FrontEnd::interrupted;
  if (near->empty() || kMostLeft * near->size() > to_.triangles.size()) return FrontEnd::declined;
  const auto part = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
  if (!part->complete()) return FrontEnd::interrupted;
  for (const Query& query : queries) {
    std::uint64_t tests = 0;
    const Nearest found = nearest(part->tree, query.point, tests, Nearest::kNone, &interrupted_);
    if (!found.complete) return FrontEnd::interrupted;
    nearest_points.push_back(found.point);
    if (found.distance > lower_) lower_ = found.distance, candidate_ = query.triangle, vertex_ = query.vertex;
  }
  off = std::max(off, part->tree.residual());
  return FrontEnd::taken;
}

FrontEnd FrontWork::keep(const std::vector<std::uint32_t>& rest, double left_out, double reach) {
  auto kept = std::make_unique<OrderedMesh>(from_, rest, direction_.from.prepared.box(), pair_.frame, control_, pool_);
  if (!kept->complete()) return FrontEnd::interrupted;
  const auto first = std::find(kept->original.begin(), kept->original.end(), candidate_) - kept->original.begin();
  if (vertex_) {  // the point that a degenerate triangle spans
    const Triangle& given = from_.triangles[candidate_];
    Triangle& candidate = kept->triangles[static_cast<std::size_t>(first)];
    candidate.fill(
        candidate[static_cast<std::size_t>(std::find(given.begin(), given.end(), *vertex_) - given.begin())]);
  }
  const MeshCells* cells = cells_of_b();
  if (!cells) return FrontEnd::interrupted;
  Vicinity vicinity(*cells);
  for (std::size_t t = 0; t < kept->triangles.size(); ++t) {
    Box box;
    for (int i = 0; i < 3; ++i) box.extend(kept->view().corner(t, i));
    vicinity.add(box, reach);
  }
  const auto near = vicinity.triangles(interrupted_);
  if (!near) return FrontEnd::interrupted;
  if (!near->empty() && kMostLeft * near->size() <= to_.triangles.size()) {
    direction_.near = std::make_unique<NearPart>(direction_.to, *near, pair_.frame, control_, pool_);
    if (!direction_.near->complete()) return FrontEnd::interrupted;
    direction_.reach = reach;
  }
  direction_.first = static_cast<std::uint32_t>(first);
  direction_.left_out = left_out;
  direction_.rest = std::move(kept);
  return FrontEnd::taken;
}

const MeshCells* FrontWork::cells_of_b() {
  if (!cells_of_b_) cells_of_b_.emplace(to_, box_of(direction_.to), pair_.frame, interrupted_);
  return cells_of_b_->complete() ? &*cells_of_b_ : nullptr;
}

Box FrontWork::box_of(const MeasuredMesh& mesh) const {
  const Box& box = mesh.prepared.box();
  return {pair_.frame.to_frame(box.low), pair_.frame.to_frame(box.high)};
}

}  // namespace meshgauge
