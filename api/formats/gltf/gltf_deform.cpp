#include "api/formats/gltf/gltf_deform.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace meshgauge::api {
namespace {

constexpr int kMostSets = 4;                 // sets of four joints; check_gltf() refuses more
constexpr double kRowTolerance = 1e-5;       // exporters invert matrices in floats
constexpr double kWeightTolerance = 0x1p-4;  // more than the rounding of eight weights of 8 bits

using Joints = std::vector<std::array<std::uint32_t, 4>>;

// The weighted sum of each vertex over its joints, before division by the sum of its weights.
struct Sums {
  explicit Sums(std::size_t vertices) : positions(vertices, Vec3::Zero()), weights(vertices, 0.0) {}

  std::vector<Vec3> positions;
  std::vector<double> weights;
};

// Returns the accessors of JOINTS_n and WEIGHTS_n; nullopt: the primitive has neither.
Result<std::optional<std::pair<std::size_t, std::size_t>>> set_of(const GltfFile& file, const GltfShape& shape, int n) {
  const auto& attributes = shape.primitive.attributes;
  const auto joints = attributes.find("JOINTS_" + std::to_string(n));
  const auto weights = attributes.find("WEIGHTS_" + std::to_string(n));
  if ((joints == attributes.end()) != (weights == attributes.end()) || (n == 0 && joints == attributes.end())) {
    return file.fail(shape.where, "a skinned mesh needs JOINTS_" + std::to_string(n) + " and WEIGHTS_" +
                                      std::to_string(n) + "; one of them is missing");
  }
  if (joints == attributes.end()) return std::optional<std::pair<std::size_t, std::size_t>>();
  return std::optional(std::pair(static_cast<std::size_t>(joints->second), static_cast<std::size_t>(weights->second)));
}

Result<Done> add_set(const GltfFile& file, const GltfShape& shape, const std::vector<GltfTransform>& transforms,
                     const Joints& joints, const std::vector<Eigen::Vector4d>& weights,
                     const std::vector<Vec3>& positions, Sums& sums) {
  if (joints.size() != positions.size() || weights.size() != positions.size()) {
    return file.fail(shape.where, "there must be one of JOINTS and WEIGHTS for each of the " +
                                      std::to_string(positions.size()) + " vertices");
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      const double weight = weights[i][static_cast<int>(k)];
      if (weight == 0) continue;
      if (weight < 0) return file.fail(shape.where, "vertex " + std::to_string(i) + " has a negative weight");
      if (joints[i][k] >= transforms.size()) {
        return at(file.source, shape.where, ErrorCode::index_out_of_range,
                  "vertex " + std::to_string(i) + " names joint " + std::to_string(joints[i][k]) +
                      ", but the skin has " + std::to_string(transforms.size()));
      }
      sums.positions[i] += weight * transforms[joints[i][k]](positions[i]);
      sums.weights[i] += weight;
    }
  }
  return Done{};
}

}  // namespace

const GltfColumn* GltfShape::column(const std::string& attribute) const {
  if (draco == nullptr) return nullptr;
  const auto found = draco->columns.find(attribute);
  return found == draco->columns.end() ? nullptr : &found->second;
}

Result<Done> GltfDeformer::morph(const GltfShape& shape, const std::vector<double>& weights,
                                 std::vector<Vec3>& positions) {
  const auto& targets = shape.primitive.targets;
  const std::size_t count = std::min(targets.size(), weights.size());
  if (auto ok = file_.budget.work(count, shape.where); !ok) return ok;
  for (std::size_t t = 0; t < count; ++t) {
    if (weights[t] == 0) continue;
    const auto accessor = targets[t].find("POSITION");
    if (accessor == targets[t].end()) continue;
    const auto read = file_.accessors.positions(static_cast<std::size_t>(accessor->second), "POSITION of a target");
    if (!read) return read.error();
    if (read->size() != positions.size()) {
      return file_.fail(
          shape.where + "." + gltf_item("targets", t),
          "moves " + std::to_string(read->size()) + " of " + std::to_string(positions.size()) + " vertices");
    }
    for (std::size_t i = 0; i < positions.size(); ++i) positions[i] += weights[t] * (*read)[i];
  }
  return Done{};
}

// Returns the joints' transforms in the pose that the file stores, where their nodes are. The transform of the mesh's
// own node is ignored, as glTF defines it.
Result<GltfDeformer::Transforms> GltfDeformer::make_joints(std::size_t index) {
  const std::string where = gltf_item("skins", index);
  const tinygltf::Skin& skin = file_.model.skins[index];
  std::vector<Eigen::Matrix4d> inverse(skin.joints.size(), Eigen::Matrix4d::Identity());
  if (skin.inverseBindMatrices >= 0) {
    auto read = file_.accessors.matrices(static_cast<std::size_t>(skin.inverseBindMatrices), skin.joints.size());
    if (!read) return std::move(read).error();
    if (read->size() < skin.joints.size()) {
      return file_.fail(where, std::to_string(read->size()) + " inverse bind matrices for " +
                                   std::to_string(skin.joints.size()) + " joints");
    }
    inverse = *std::move(read);
  }
  Transforms out;
  for (std::size_t j = 0; j < skin.joints.size(); ++j) {
    const auto world = world_.of(static_cast<std::size_t>(skin.joints[j]));
    if (!world) return world.error();
    const Eigen::RowVector4d last(0, 0, 0, 1);
    if (!((inverse[j].row(3) - last).cwiseAbs().maxCoeff() <= kRowTolerance)) {
      return file_.fail(where, "the last row of inverse bind matrix " + std::to_string(j) + " must be 0 0 0 1");
    }
    out.push_back(composed(*world, {inverse[j].topLeftCorner<3, 3>(), inverse[j].topRightCorner<3, 1>()}));
  }
  return out;
}

Result<const GltfDeformer::Transforms*> GltfDeformer::joints(std::size_t skin) {
  auto known = skins_.find(skin);
  if (known == skins_.end()) {
    if (skin >= file_.model.skins.size()) return file_.fail(gltf_item("skins", skin), "does not exist");
    auto made = make_joints(skin);
    if (!made) return std::move(made).error();
    known = skins_.emplace(skin, *std::move(made)).first;
  }
  return &known->second;
}

Result<Done> GltfDeformer::skin(const GltfShape& shape, std::size_t skin, std::vector<Vec3>& positions) {
  const auto transforms = joints(skin);
  if (!transforms) return transforms.error();
  Sums sums(positions.size());
  for (int n = 0; n < kMostSets; ++n) {
    const auto set = set_of(file_, shape, n);
    if (!set) return set.error();
    if (!*set) break;
    if (auto ok = file_.budget.work(4 * positions.size(), shape.where); !ok) return ok;  // four joints per vertex
    const std::string number = std::to_string(n);
    const auto joints = file_.accessors.joints((*set)->first, shape.column("JOINTS_" + number));
    if (!joints) return joints.error();
    const auto weights = file_.accessors.weights((*set)->second, shape.column("WEIGHTS_" + number));
    if (!weights) return weights.error();
    if (auto ok = add_set(file_, shape, **transforms, *joints, *weights, positions, sums); !ok) return ok;
  }
  for (std::size_t i = 0; i < positions.size(); ++i) {
    if (!(std::abs(sums.weights[i] - 1) <= kWeightTolerance)) {
      return file_.fail(shape.where, "the weights of vertex " + std::to_string(i) + " do not add up to 1");
    }
    positions[i] = sums.positions[i] / sums.weights[i];
  }
  return Done{};
}

}  // namespace meshgauge::api
