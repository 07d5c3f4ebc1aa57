#include "engine/measure/build_stage.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/fast/front.h"
#include "engine/fast/twins.h"
#include "engine/search/conclusion.h"

namespace meshgauge {
namespace {

constexpr std::size_t kWorthThreads = std::size_t{1} << 14;  // triangles; the start of a thread takes as long as 500

// Calls work(mesh, pool) for both meshes: in parallel, each with half of the threads, where they are large enough.
template <class Work>
void on_both_meshes(MeasuredPair& pair, ThreadPool& pool, const Work& work) {
  const std::array meshes{&pair.a, &pair.b};
  if (pool.size() == 1 || pair.a.given().triangles.size() + pair.b.given().triangles.size() < kWorthThreads) {
    for (MeasuredMesh* mesh : meshes) work(*mesh, pool);
  } else {
    pool.run(meshes.size(), [&](std::size_t, std::size_t i) {
      ThreadPool half(std::max<std::size_t>(pool.size() / 2, 1));
      work(*meshes[i], half);
    });
  }
}

// Whether one of two threads has little to wait for if each takes a mesh.
bool are_similar_in_size(MeshView a, MeshView b) {
  const auto [small, large] = std::minmax({a.triangles.size(), b.triangles.size()});  // of a list: by value
  return 2 * small >= large;
}

Box joint(Box box, const Box& other) {
  box.extend(other);
  return box;
}

class BuildStage {
 public:
  BuildStage(MeasuredPair& pair, Strategy strategy, ThreadPool& pool, Control& control)
      : pair_(pair), is_auto_(strategy == Strategy::automatic), pool_(pool), control_(control) {}

  std::optional<Stop> run(const Goal& goal, const Slack& slack) {
    if (is_auto_) {
      double known = 0;  // the largest distance found
      for (MeasuredDirection& direction : pair_.directions) {
        const FrontEnd end = take_front(pair_, direction, goal, slack, known, control_, pool_);
        if (end == FrontEnd::declined) leave_out_shared(direction);
        if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
      }
    }
    build_orders();
    if (const auto why = control_.check(); why != Interruption::none) return to_stop(why);
    for (MeasuredMesh* mesh : {&pair_.a, &pair_.b}) {
      if (!needs_tree(*mesh)) continue;
      mesh->tree = mesh->framed->tree(control_, pool_);
      if (!mesh->tree) return to_stop(control_.check());
    }
    return std::nullopt;
  }

 private:
  // The paper's traversal needs two trees. `auto` needs none of the mesh measured from: it goes over its triangles.
  bool needs_tree(const MeasuredMesh& mesh) const {
    return !is_auto_ || std::any_of(pair_.directions.begin(), pair_.directions.end(), [&](const MeasuredDirection& d) {
      return &d.to == &mesh && !d.settled && !d.near;
    });
  }

  bool needs_order(const MeasuredMesh& mesh) const {
    return needs_tree(mesh) ||
           std::any_of(pair_.directions.begin(), pair_.directions.end(),
                       [&](const MeasuredDirection& d) { return &d.from == &mesh && !d.settled && !d.rest; });
  }

  void build_orders() {
    const auto order = [this](MeasuredMesh& mesh, ThreadPool& pool) {
      mesh.ordered = mesh.framed->order(control_, pool);
    };
    const bool a = needs_order(pair_.a), b = needs_order(pair_.b);
    if (a && b && are_similar_in_size(pair_.a.given(), pair_.b.given())) {
      on_both_meshes(pair_, pool_, order);
    } else {
      if (a) order(pair_.a, pool_);
      if (b) order(pair_.b, pool_);
    }
  }

  // A triangle that `to` has, too, is at distance 0 and needs no measuring.
  void leave_out_shared(MeasuredDirection& direction) {
    const MeasuredMesh& from = direction.from;
    const auto twins = shared_triangles(from.given(), direction.to.prepared,
                                        [this] { return control_.check() != Interruption::none; });
    if (twins.empty()) return;
    std::vector<std::uint32_t> rest;
    rest.reserve(static_cast<std::size_t>(std::count(twins.begin(), twins.end(), kNoTwin)));
    for (std::uint32_t t = 0; t < twins.size(); ++t) {
      if (twins[t] == kNoTwin) rest.push_back(t);
    }
    if (!rest.empty()) {
      direction.rest =
          std::make_unique<OrderedMesh>(from.given(), rest, from.prepared.box(), pair_.frame, control_, pool_);
      return;
    }
    const Vec3& point = from.given().corner(0, 0);
    direction.result.bounds = pair_.error.widened({0, 0, Witness{point, 0, point, twins[0]}});
    direction.result.culling.survivors = 0;
    direction.settled = true;
  }

  MeasuredPair& pair_;
  const bool is_auto_;
  ThreadPool& pool_;
  Control& control_;
};

}  // namespace

void enter_frame(MeasuredPair& pair, const Kernels& kernels, ThreadPool& pool) {
  on_both_meshes(pair, pool, [](MeasuredMesh& mesh, ThreadPool&) { (void)mesh.prepared.box(); });
  pair.frame = Frame(joint(pair.a.prepared.box(), pair.b.prepared.box()));
  for (MeasuredMesh* mesh : {&pair.a, &pair.b}) mesh->framed = mesh->prepared.in(pair.frame, kernels);
}

std::optional<Stop> build(MeasuredPair& pair, Strategy strategy, const Goal& goal, const Slack& slack, ThreadPool& pool,
                          Control& control) {
  return BuildStage(pair, strategy, pool, control).run(goal, slack);
}

}  // namespace meshgauge
