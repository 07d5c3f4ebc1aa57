#include "check/html/picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "api/base/refused.h"
#include "api/compare/compare.h"
#include "check/html/image.h"
#include "check/html/render.h"
#include "check/html/strip.h"
#include "engine/tree/nearest.h"

namespace meshgauge::check {
namespace {

struct Size {
  int width;
  int height;
};
constexpr Size kLarge{640, 480}, kSmall{400, 300};
constexpr std::size_t kManyPoints = 40'000, kFewPoints = 10'000;

// Smallest and largest reach of a close-up, as shares of the diagonal of both meshes.
constexpr double kClosest = 0.05, kWidest = 0.2;
constexpr double kMostMagnified = 60;  // relative to the whole view

// What all views of one gate share.
struct Scene {
  const GateOutcome& outcome;
  Frame frame;
  double diagonal = 0;
  ChosenView chosen;
  std::optional<Witness> witness;
  ThreadPool& pool;
  Control& control;
};

// Thrown to stop a picture; caught in this file.
struct Stopped {};

void go_on(Control& control) {
  if (control.check() != Interruption::none) throw Stopped();
}

struct Side {
  const Prepared& mesh;
  const Prepared& other;
  bool candidate;
};

// A service could send any witness; a real one lies on the meshes.
bool lies_in(const Box& box, const Vec3& p) {
  const Vec3 slack = Vec3::Constant(1e-6 * diagonal(box));
  return (p.array() >= (box.low - slack).array()).all() && (p.array() <= (box.high + slack).array()).all();
}

std::optional<Witness> checked(const std::optional<Witness>& witness, const Box& box, const Prepared& from) {
  if (!witness || !lies_in(box, witness->from) || !lies_in(box, witness->to)) return std::nullopt;
  if (witness->from_triangle >= from.mesh().triangles.size()) return std::nullopt;
  return witness;
}

Vec3 normal(MeshView mesh, const Frame& frame, std::uint32_t triangle) {
  const Vec3 a = frame.to_frame(mesh.corner(triangle, 0));
  const Vec3 n = (frame.to_frame(mesh.corner(triangle, 1)) - a).cross(frame.to_frame(mesh.corner(triangle, 2)) - a);
  return n.norm() > 0 ? Vec3(n.normalized()) : Vec3(Vec3::Zero());
}

// glTF is y up by specification and most OBJ are; CAD and printing use z up.
int up_axis(const nlohmann::ordered_json& document) {
  const std::string format = document.at("meshes").at("a").at("format").get<std::string>();
  return format == "gltf" || format == "glb" || format == "obj" ? 1 : 2;
}

// `from` and `to`: the meshes of the witness.
ChosenView chosen_view(const Scene& scene, const Prepared& from, const Prepared& to, const Box& box) {
  const int up = up_axis(scene.outcome.measured->document);
  if (!scene.witness) {
    return choose_view({from.mesh(), 0.5 * box.low + 0.5 * box.high}, std::nullopt, scene.frame, Vec3::Zero(), up);
  }
  const Sight nearest{to.mesh(), scene.witness->to};
  return choose_view({from.mesh(), scene.witness->from}, nearest, scene.frame,
                     normal(from.mesh(), scene.frame, scene.witness->from_triangle), up);
}

void mark(Shot& shot, const Scene& scene) {
  if (!scene.witness) return;
  shot.from = shot.camera.see(scene.witness->from);
  shot.to = shot.camera.see(scene.witness->to);
}

Shot whole_shot(const Scene& scene, const Side& side, Paint& paint, const Size& size) {
  std::vector<Vec3> points;
  if (scene.witness) points = {scene.witness->from, scene.witness->to};
  Shot shot;
  go_on(scene.control);
  shot.camera = whole_view(side.mesh.mesh(), scene.frame, scene.chosen.view, points, size.width, size.height);
  paint.inside = inside_of(side.mesh.mesh(), shot.camera);
  shot.png = to_png(render(side.mesh.mesh(), shot.camera, paint, scene.pool));
  mark(shot, scene);
  if (scene.witness) {
    const Vec3& own = scene.witness->on_candidate == side.candidate ? scene.witness->from : scene.witness->to;
    shot.hidden = covered(side.mesh.mesh(), scene.frame, scene.chosen.view, own);
  }
  return shot;
}

double reach(const Scene& scene, const Camera& whole) {
  const double shown = 6 * std::max(scene.outcome.measured->lower, scene.outcome.measured->shown().limit);
  const double wanted = std::clamp(shown, kClosest * scene.diagonal, kWidest * scene.diagonal);
  return std::max(wanted, 0.5 * kLarge.height / kMostMagnified * whole.pixel_size());
}

// If the part covers the witness, it is cut open in front of it.
Shot close_shot(const Scene& scene, const Side& side, const Paint& paint, Shot& whole) {
  const double wide = reach(scene, whole.camera);
  whole.close_up = 2 * wide / (whole.camera.height * whole.camera.pixel_size());
  Shot shot;
  shot.camera = close_view(whole.camera, scene.witness->from, wide, kLarge.width, kLarge.height);
  mark(shot, scene);
  shot.cut = whole.hidden;
  const double before = std::max(shot.from->depth, shot.to->depth) + 0.01 * kLarge.height;
  const double cut = shot.cut ? before : std::numeric_limits<double>::infinity();
  shot.png = to_png(render(side.mesh.mesh(), shot.camera, paint, scene.pool, cut));
  return shot;
}

// In the frame: smaller distances are rounding errors of a point on the mesh.
constexpr double kOnMesh = 0x1p-44;

// Distances of points to a mesh. Computed, not certified: for pictures and histograms, never for verdicts.
class DistanceField {
 public:
  // Borrows `mesh`. `box` contains the mesh and all points that will be asked for. Builds a tree, unless the mesh has
  // one for that frame. If `control` stops it, complete() is false and at() must not be called.
  DistanceField(const Prepared& mesh, const Box& box, ThreadPool& pool, Control& control)
      : frame_(box), framed_(mesh.in(frame_, *find_kernels("auto"))), tree_(framed_->tree(control, pool)) {}

  bool complete() const { return tree_ != nullptr; }

  // In the meshes' unit; thread safe.
  double at(const Vec3& point) const {
    std::uint64_t tests = 0;
    const double distance = nearest(*tree_, frame_.to_frame(point), tests).distance;
    return distance < kOnMesh ? 0 : std::ldexp(distance, frame_.exponent());
  }

  // at(), which ends the picture when it is cancelled. Borrows both.
  std::function<double(const Vec3&)> until_cancelled(const Control& control) const {
    return [this, &control](const Vec3& p) {
      if (control.cancelled()) throw Stopped();
      return at(p);
    };
  }

 private:
  Frame frame_;
  std::shared_ptr<Framed> framed_;
  const Bvh* tree_;
};

api::ColourScale scale_of(const Scene& scene) { return {scene.outcome.measured->shown().limit, true}; }

Surface surface(const Scene& scene, const Side& side, const Box& box) {
  const DistanceField field(side.other, box, scene.pool, scene.control);
  if (!field.complete()) throw Stopped();
  Paint paint{field.until_cancelled(scene.control), scale_of(scene), Inside::unknown};
  const bool large = scene.outcome.measured->verdict != Verdict::pass;
  Surface made{side.candidate, paint.scale, whole_shot(scene, side, paint, large ? kLarge : kSmall), std::nullopt, {}};
  if (large && scene.witness) made.close_up = close_shot(scene, side, paint, made.whole);
  made.histogram =
      histogram_of(side.mesh.mesh(), paint.distance, paint.scale.top, large ? kManyPoints : kFewPoints, scene.pool);
  return made;
}

Camera common_camera(const Scene& scene, MeshView candidate, MeshView baseline) {
  std::vector<Vec3> points;
  if (scene.witness) points = {scene.witness->from, scene.witness->to};
  const MeshView both[] = {candidate, baseline};
  return common_view(both, scene.frame, scene.chosen.view, points, kStripViewWidth, kStripViewHeight);
}

std::vector<std::byte> strip_png(const Scene& scene, const Prepared& candidate, const Prepared& baseline,
                                 const Box& box) {
  go_on(scene.control);
  const Direction direction = scene.outcome.gate.request.options.direction;
  StripScene shown{{candidate.mesh(), {}}, {baseline.mesh(), {}}, {}, scale_of(scene), std::nullopt};
  std::vector<std::unique_ptr<const DistanceField>> fields;
  const auto add_distance = [&](StripMesh& from, const Prepared& to) {
    fields.push_back(std::make_unique<const DistanceField>(to, box, scene.pool, scene.control));
    if (!fields.back()->complete()) throw Stopped();
    from.distance = fields.back()->until_cancelled(scene.control);
  };
  if (direction != Direction::b_to_a) add_distance(shown.candidate, baseline);
  if (direction != Direction::a_to_b) add_distance(shown.baseline, candidate);
  shown.camera = common_camera(scene, candidate.mesh(), baseline.mesh());
  if (scene.witness) shown.mark = shown.camera.see(scene.witness->from);
  return marked(to_png_within(strip_of(shown, scene.pool), kStripBytes - kMarkBytes));
}

void draw_surfaces(const Scene& scene, const Prepared& candidate, const Prepared& baseline, const Box& box,
                   GatePicture& picture) {
  const Direction direction = scene.outcome.gate.request.options.direction;
  if (direction != Direction::b_to_a) picture.surfaces.push_back(surface(scene, {candidate, baseline, true}, box));
  const bool both = direction == Direction::symmetric && scene.outcome.measured->verdict != Verdict::pass;
  if (both || direction == Direction::b_to_a) {
    picture.surfaces.push_back(surface(scene, {baseline, candidate, false}, box));
  }
}

// Reads one of a gate's files and checks that it is still the one that was measured.
Result<api::SharedMesh> read(const std::filesystem::path& path, const std::string& part, const GateOutcome& outcome,
                             Meshes& meshes, Control& control) {
  auto mesh = meshes.get(path, control);
  if (!mesh) return mesh;
  if (outcome.measured->document.at("meshes").at(part).at("sha256") == (*mesh)->facts.sha256) return mesh;
  return refused("'" + path.string() + "' is no longer the file that was measured", part);
}

GatePicture without(const std::string& why) { return {{}, why}; }

}  // namespace

GatePicture make_picture(const Prepared& candidate, const Prepared& baseline, const GateOutcome& outcome,
                         ThreadPool& pool, Control& control, const Drawn& drawn) try {
  const Measured& measured = *outcome.measured;
  Box box = candidate.box();
  box.extend(baseline.box());
  const bool from_baseline = measured.witness && !measured.witness->on_candidate;
  const Prepared& from = from_baseline ? baseline : candidate;
  Scene scene{outcome, Frame(box), diagonal(box), {}, checked(measured.witness, box, from), pool, control};
  scene.chosen = chosen_view(scene, from, from_baseline ? candidate : baseline, box);

  GatePicture picture;
  if (drawn.surfaces) draw_surfaces(scene, candidate, baseline, box, picture);
  if (drawn.strip) picture.strip = strip_png(scene, candidate, baseline, box);
  return picture;
} catch (const Stopped&) {
  return without("the run was interrupted");
}

GatePicture picture_of(const GateOutcome& outcome, Meshes& meshes, ThreadPool& pool, Control& control,
                       const Drawn& drawn) try {
  const Turn turn{meshes, outcome.gate};
  if (!outcome.measured) return without("nothing was measured");
  const auto candidate = read(outcome.gate.candidate, "a", outcome, meshes, control);
  if (!candidate) return without(candidate.error().message);
  const auto baseline = read(outcome.gate.baseline, "b", outcome, meshes, control);
  if (!baseline) return without(baseline.error().message);
  const auto pair =
      api::in_unit_of_result(*candidate, *baseline, outcome.measured->units, outcome.measured->motion, control);
  if (!pair) return without(pair.error().message);
  return make_picture(*pair->a, *pair->b, outcome, pool, control, drawn);
} catch (const std::bad_alloc&) {
  return without("there is not enough memory for a picture");
} catch (const nlohmann::json::exception&) {
  return without("the result does not name the files that were measured");
} catch (const std::exception& error) {
  return without(std::string("it could not be made: ") + error.what());
}

}  // namespace meshgauge::check
