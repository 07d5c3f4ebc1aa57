#include "engine/fast/sweep.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "engine/fast/bounds/lipschitz.h"
#include "engine/fast/bounds/overlay.h"
#include "engine/fast/bounds/patch.h"
#include "engine/fast/twins.h"
#include "engine/rounding.h"
#include "engine/search/search_worker.h"

namespace meshgauge {
namespace {

constexpr std::size_t kBlocksARound = 16;        // for each thread, between two pulses: about 1 ms
constexpr std::uint64_t kTestsARound = 1 << 19;  // limit of its point-triangle distances in a round: about 10 ms
constexpr std::size_t kBlocksWorthThreads = 16;  // fewer blocks take less time than the start of a thread
constexpr std::size_t kMaxVisits = 64;           // limit of the triangles of B over one of A
constexpr std::size_t kAdjacencyShare = 8;  // triangles of B whose adjacency costs as much as one failed certificate
constexpr std::size_t kBlocksBeforeProbe = 32;  // one of so many is visited before, to raise the lower bound
constexpr std::size_t kProbes = 32;             // blocks of A that are probed for whether to make the adjacency at once
constexpr std::size_t kProbeLength = 4;         // triangles of each
// The patch certificate is tried where one of so many triangles that no guess culls survives; where all but one of so
// many survive, also for so many times fewer triangles.
constexpr std::size_t kFewer = 4;
// What the other bounds of a triangle cost, in point-triangle distances: if that of the centroid mostly succeeds, or
// mostly fails.
constexpr std::uint64_t kTestsOfCentroid = 80;
constexpr std::uint64_t kTestsOfCorners = 300;

// The distance of a vertex of A from B and a triangle for its queries. Thread safe: two threads may measure a vertex of
// two blocks at the same time, and both results are right.
class Vertex {
 public:
  bool measured() const { return distance_.load(std::memory_order_acquire) >= 0; }
  double distance() const { return distance_.load(std::memory_order_relaxed); }
  // The nearest triangle of B if measured(), else one that culled a neighbour, or kNone.
  std::uint32_t slot() const { return slot_.load(std::memory_order_relaxed); }
  void set(double distance, std::uint32_t slot) {
    slot_.store(slot, std::memory_order_relaxed);
    distance_.store(distance, std::memory_order_release);
  }
  void suggest(std::uint32_t slot) {
    if (!measured()) slot_.store(slot, std::memory_order_relaxed);
  }

 private:
  std::atomic<double> distance_{-1};
  std::atomic<std::uint32_t> slot_{Nearest::kNone};
};

// Whether a corner of the triangle is measured and beyond `limit`.
bool is_beyond(std::span<const Vertex> vertices, const Triangle& triangle, double limit) {
  return std::any_of(triangle.begin(), triangle.end(), [&](std::uint32_t v) { return vertices[v].distance() > limit; });
}

// The recent success rate of a kind of attempt, to decide whether to try it.
class Record {
 public:
  // `rate`: the success rate to begin with. `memory`: about so many attempts count.
  explicit Record(float rate = 0, float memory = 16) : rate_(rate), memory_(memory) {}
  bool note(bool success) {
    rate_ += ((success ? 1.0F : 0.0F) - rate_) / memory_;
    return success;
  }
  // Whether more than half of the recent attempts succeeded. Also true for every 64th call, to notice a change.
  bool promising() { return good() || ++asked_ % 64 == 0; }
  bool good() const { return rate_ > 0.5F; }
  // Whether one of some thirty recent attempts succeeded. Also true for every 32nd call.
  bool possible() { return rate_ > 1.0F / 32 || ++skipped_ % 32 == 0; }

 private:
  float rate_;
  float memory_;
  unsigned asked_ = 0;
  unsigned skipped_ = 0;
};

// Up to four different triangles of B.
class Hints {
 public:
  void add(std::uint32_t slot) {
    const auto end = slots_.begin() + size_;
    if (slot != Nearest::kNone && std::find(slots_.begin(), end, slot) == end)
      slots_[static_cast<std::size_t>(size_++)] = slot;
  }
  std::span<const std::uint32_t> span() const { return {slots_.data(), static_cast<std::size_t>(size_)}; }

 private:
  std::array<std::uint32_t, 4> slots_;
  std::ptrdiff_t size_ = 0;
};

// What attempts have shown.
struct Experience {
  Record guesses;           // attempts with triangles of B that need no query
  Record patches{1, 4};     // attempts with the patch certificate, by block
  Record centroids{0.25F};  // attempts with the triangle nearest to the centroid
  Record overlays;          // attempts with the overlay bound
  Record twins;             // attempts with the triangle of the same number
  Record successors;        // attempts with the triangle after `last`
};

// One thread's state in the sweep. No two share a cache line, which both would write.
struct alignas(64) Sweeper : Experience {
  SearchWorker worker;
  std::optional<Overlay> overlay;
  std::optional<Patch> patch;
  // The triangle of B used last; kNone as long as other threads have measured all vertices that this one needed.
  std::uint32_t last = Nearest::kNone;
  std::size_t guessed = 0;          // triangles of A for which guesses were tried
  std::size_t uncertified = 0;      // of those, the ones that no guess culled
  std::vector<std::uint32_t> left;  // triangles of the block that are not culled yet

  explicit Sweeper(Search& search) : worker(search) {}
};

const Sweeper& most_experienced(const std::deque<Sweeper>& sweepers) {
  return *std::max_element(sweepers.begin(), sweepers.end(),
                           [](const Sweeper& x, const Sweeper& y) { return x.guessed < y.guessed; });
}

// Lets all threads go on with this experience: to learn the same takes each of them hundreds of triangles.
void share(const Experience& known, std::deque<Sweeper>& sweepers) {
  for (Sweeper& sweeper : sweepers) static_cast<Experience&>(sweeper) = known;
}

// Consecutive triangles of A, which are neighbours in space.
struct Block {
  std::size_t begin = 0;  // triangles of A
  std::size_t end = 0;
  double upper = 0;      // of h(block, B), computed
  bool bounded = false;  // `upper` is known
  bool visited = false;  // all its triangles are dropped or wait as pieces
};

class Sweep {
 public:
  Sweep(Search& search, const OrderedMesh& from, const OrderedMesh& to)
      : search_(search), from_(from), to_(to), vertices_(search.from().positions.size()) {
    for (std::size_t i = 0; i < search.pool().size(); ++i) sweepers_.emplace_back(search);
  }

  std::optional<Stop> run() {
    if (const auto stop = bound_blocks()) return give_up(stop);
    twins_ = twins_by_number(from_, to_);
    // Largest bound first: the current block's bound covers all that is not visited yet, and soon the rest can be
    // dropped at once.
    std::sort(blocks_.begin(), blocks_.end(), [](const Block& a, const Block& b) {
      return std::pair(-a.upper, a.begin) < std::pair(-b.upper, b.begin);
    });
    const std::size_t round = kBlocksARound * search_.pool().size();
    bool probed = false;
    for (std::size_t begin = 0;;) {
      while (begin < blocks_.size() && blocks_[begin].visited) ++begin;
      if (begin == blocks_.size()) break;
      search_.set_unvisited(blocks_[begin].upper);
      if (const auto stop = search_.pulse()) return give_up(stop);
      if (search_.over_budget()) return give_up(Stop::budget);
      if (blocks_[begin].upper <= search_.cull_within_tolerance()) {
        search_.drop(blocks_[begin].upper);
        for (; begin < blocks_.size(); ++begin) note(blocks_[begin]);
        break;
      }
      if (overlay_pays(probed)) adopt_overlay();
      if (begin > 0 && !std::exchange(probed, true) && probe(begin)) adopt_patch();
      const std::size_t size = probed ? round : std::min(kBlocksARound, 1 + blocks_.size() / kBlocksBeforeProbe);
      const std::size_t end = std::min(begin + size, blocks_.size());
      run_tasks(end - begin, [&](Sweeper& sweeper, std::size_t i) { visit(sweeper, blocks_[begin + i]); });
    }
    search_.keep_above(search_.cull_within_tolerance());  // the lower bound has risen since the first pieces survived
    search_.survivors() = search_.waiting();
    search_.set_unvisited(0);
    return std::nullopt;
  }

 private:
  // Calls work(sweeper, i) for each i below `count`, on all threads if it is worth it, and absorbs the results. A
  // thread that has reached kTestsARound skips its further tasks; the next round does them, so that pulses stay
  // frequent.
  template <class Work>
  void run_tasks(std::size_t count, Work&& work) {
    const auto task = [&](std::size_t w, std::size_t i) {
      if (sweepers_[w].worker.work().triangle_tests < kTestsARound) work(sweepers_[w], i);
    };
    if (blocks_.size() < kBlocksWorthThreads) {
      for (std::size_t i = 0; i < count; ++i) task(0, i);
    } else {
      search_.pool().run(count, task);
    }
    for (Sweeper& sweeper : sweepers_) search_.absorb(sweeper.worker);
    share(most_experienced(sweepers_), sweepers_);
  }

  // Bounds each block's box by eq. 4/5 and measures one of its vertices, which gives most of the final lower bound.
  std::optional<Stop> bound_blocks() {
    const std::size_t triangles = search_.from().triangles.size();
    const std::size_t size = search_.thresholds().block;
    for (std::size_t first = 0; first < triangles; first += size) {
      blocks_.push_back(Block{first, std::min(first + size, triangles)});
    }
    const std::size_t round = 8 * kBlocksARound * search_.pool().size();
    for (std::size_t begin = 0;;) {
      while (begin < blocks_.size() && blocks_[begin].bounded) ++begin;
      if (const auto stop = search_.pulse()) return stop;
      if (begin == blocks_.size()) return std::nullopt;
      run_tasks(std::min(round, blocks_.size() - begin),
                [&](Sweeper& sweeper, std::size_t i) { bound(sweeper, blocks_[begin + i]); });
    }
  }

  void bound(Sweeper& sweeper, Block& block) {
    if (block.bounded || sweeper.worker.interrupted()) return;
    Box box;
    double known = 0;
    for (std::size_t t = block.begin; t < block.end; ++t) {
      for (int i = 0; i < 3; ++i) box.extend(search_.from().corner(t, i));
      known = std::max(known, search_.known(t));
    }
    block.upper = known;
    block.bounded = std::isfinite(known) && known <= sweeper.worker.cull_within_tolerance();
    if (block.bounded) return;
    measure(sweeper, search_.from().triangles[block.begin][0], static_cast<std::uint32_t>(block.begin));
    const Vec3 centre = (box.low + box.high) * 0.5;
    Work& work = sweeper.worker.work();
    ++work.nearest_queries;
    block.upper =
        farthest_of_box(box, nearest(search_.to(), centre, work.triangle_tests, sweeper.last, search_.stop()).point);
    block.bounded = true;
  }

  // Ends the sweep early: counts the triangles that are not visited as survivors. Returns `stop`.
  std::optional<Stop> give_up(std::optional<Stop> stop) {
    std::size_t unvisited = 0;
    for (const Block& block : blocks_) unvisited += block.visited ? 0 : block.end - block.begin;
    search_.survivors() = search_.waiting() + unvisited;
    return stop;
  }

  // Tries guesses for a few triangles all over A. Returns whether adjacency will pay, judged by how many of them fail.
  // The blocks before `begin` are visited.
  bool probe(std::size_t begin) {
    const double limit = search_.cull_within_tolerance();
    const auto first = blocks_.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto end = std::partition_point(first, blocks_.end(), [&](const Block& b) { return b.upper > limit; });
    const auto to_come = static_cast<std::size_t>(end - first);
    const std::size_t probes = std::min(kProbes, to_come);
    std::size_t tried = 0, failed = 0;
    for (std::size_t i = 0; i < probes; ++i) {
      const Block& block = blocks_[begin + i * to_come / probes];
      for (std::size_t t = block.begin; t < std::min(block.begin + kProbeLength, block.end); ++t, ++tried) {
        if (!probed(sweepers_[0], static_cast<std::uint32_t>(t))) ++failed;
      }
    }
    share(sweepers_.front(), sweepers_);  // which has tried them
    const auto [guessed, uncertified] = guesses();
    if (tried == 0 || guessed == 0) return false;
    const std::size_t expected =
        std::min(failed * to_come / tried, uncertified * to_come / guessed) * search_.thresholds().block;
    // The other bounds are cheap where they cull what guesses do not, and dear where they cull little of it.
    const std::size_t survivors = search_.waiting();
    if (kFewer * survivors < uncertified) return false;
    const bool most_survive = kFewer * survivors >= (kFewer - 1) * uncertified;
    const std::size_t worth = search_.thresholds().patches / (most_survive ? kFewer : 1);
    return 2 * failed >= tried && 2 * uncertified >= guessed &&
           expected >= std::max(worth, has_adjacency_ ? 0 : search_.to().mesh().triangles.size() / kAdjacencyShare);
  }
  // The triangles of A for which guesses were tried, and of those the ones that no guess culled.
  std::pair<std::size_t, std::size_t> guesses() const {
    std::pair<std::size_t, std::size_t> sum{0, 0};
    for (const Sweeper& sweeper : sweepers_) sum.first += sweeper.guessed, sum.second += sweeper.uncertified;
    return sum;
  }
  // Whether the triangle's twin or a hint culls it.
  bool probed(Sweeper& sweeper, std::uint32_t t) {
    const Triangle& triangle = search_.from().triangles[t];
    const Certificate certificate = certificate_of(t);
    const std::uint32_t twin = twins_.empty() ? kNoTwin : twins_[t];
    bool culled = twin != kNoTwin && sweeper.twins.note(certified(sweeper, certificate, t, twin));
    const Hints known = hints(sweeper, triangle);
    culled = culled || std::any_of(known.span().begin(), known.span().end(),
                                   [&](std::uint32_t hint) { return certified(sweeper, certificate, t, hint); });
    return sweeper.guesses.note(culled);
  }

  // Whether so many triangles have failed that the overlay bound pays.
  bool overlay_pays(bool probed) const {
    if (sweepers_[0].overlay) return false;
    if (has_adjacency_ && probed) return true;
    return guesses().second >=
           std::max(search_.thresholds().adjacency, search_.to().mesh().triangles.size() / kAdjacencyShare);
  }
  void adopt_overlay() {
    if (!search_.take_adjacency()) return;
    for (Sweeper& sweeper : sweepers_) sweeper.overlay.emplace(search_.to(), *search_.adjacency());
  }
  void adopt_patch() {
    if (!search_.take_adjacency()) return;
    for (Sweeper& sweeper : sweepers_)
      sweeper.patch.emplace(search_.to(), *search_.adjacency(), search_.thresholds().patch_group);
  }

  void visit(Sweeper& sweeper, Block& block) {
    if (block.visited) return;
    if (block.upper <= search_.cull_within_tolerance()) {
      sweeper.worker.drop(block.upper);
      note(block);
    } else {
      const std::size_t pieces = sweeper.worker.waiting();
      sweeper.left.clear();
      for (std::size_t t = block.begin; t < block.end; ++t) {
        const double known = search_.known(t);
        known > sweeper.worker.cull_within_tolerance() ? sweeper.left.push_back(static_cast<std::uint32_t>(t))
                                                       : sweeper.worker.drop(known);
      }
      const bool guessed = patched(sweeper);
      for (const std::uint32_t t : sweeper.left) {
        if (sweeper.worker.interrupted()) return sweeper.worker.forget_beyond(pieces);
        visit(sweeper, t, block.upper, guessed);
      }
    }
    block.visited = true;
  }

  // Culls triangles of the block with the patch certificate. Returns whether it has tried guesses before.
  bool patched(Sweeper& sweeper) {
    if (!sweeper.patch || !sweeper.patches.promising()) return false;
    const bool guess_first = sweeper.guesses.promising();
    if (guess_first) {
      std::erase_if(sweeper.left, [&](std::uint32_t t) { return culled_by_guess(sweeper, certificate_of(t), t); });
    }
    if (sweeper.left.size() < search_.thresholds().triangles_a_patch) return guess_first;
    const double limit = sweeper.worker.cull_within_tolerance();
    Work& work = sweeper.worker.work();
    const std::uint64_t tests = work.triangle_tests;
    const std::span bounds = sweeper.patch->attempt(search_.from(), sweeper.left, limit, work);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < bounds.size(); ++i) {
      const std::uint32_t t = sweeper.left[i];
      if (!(bounds[i].upper <= limit)) {
        sweeper.left[kept++] = t;
        continue;
      }
      sweeper.worker.drop(t, bounds[i].upper);
      for (const std::uint32_t v : search_.from().triangles[t]) vertices_[v].suggest(bounds[i].under);
    }
    sweeper.left.resize(kept);
    const std::uint64_t saved = sweeper.centroids.good() ? kTestsOfCentroid : kTestsOfCorners;
    sweeper.patches.note((bounds.size() - kept) * saved >= work.triangle_tests - tests);
    return guess_first;
  }

  Certificate certificate_of(std::uint32_t t) const {
    std::array<Corner, 3> corners;
    for (int i = 0; i < 3; ++i) corners[static_cast<std::size_t>(i)].point = search_.from().corner(t, i);
    return Certificate(corners, search_.to());
  }

  // `guessed`: guesses have been tried.
  void visit(Sweeper& sweeper, std::uint32_t t, double block_upper, bool guessed) {
    SearchWorker& worker = sweeper.worker;
    const Triangle& triangle = search_.from().triangles[t];
    Piece piece;
    piece.triangle = t;
    for (std::size_t i = 0; i < 3; ++i) piece.corners[i].point = search_.from().positions[triangle[i]];
    piece.upper = block_upper;
    const Certificate certificate(piece.corners, search_.to());
    // No bound is within it if a corner is beyond. Without it, every piece that waits has measured corners.
    const auto limit = search_.goal().cull_at;
    if (limit && is_beyond(vertices_, triangle, *limit)) return worker.push(piece);
    if (!guessed && culled_by_guess(sweeper, certificate, t)) return;
    // These two need no measured corners. Each is tried first if it has succeeded recently.
    const bool centroid_first = sweeper.centroids.promising();
    if (centroid_first && owned_by_centroid(sweeper, piece, certificate)) return;
    if (!centroid_first && sweeper.overlays.promising() && overlaid(sweeper, piece, hints(sweeper, triangle).span()))
      return;

    for (std::size_t i = 0; i < 3; ++i) piece.corners[i] = measure(sweeper, triangle[i], t);
    if (limit && is_beyond(vertices_, triangle, *limit)) return worker.push(piece);
    const std::array owners{piece.corners[0].slot, piece.corners[1].slot, piece.corners[2].slot};
    piece.upper =
        std::min({piece.upper, lipschitz_upper(piece), least_farthest(piece, search_.to(), owners, worker.work())});
    if (piece.upper <= worker.cull_within_tolerance()) return worker.drop(t, piece.upper);
    if (overlaid(sweeper, piece, owners)) return;
    if (!centroid_first && !piece.overlay_failed && sweeper.centroids.possible() &&
        owned_by_centroid(sweeper, piece, certificate))
      return;
    if (overlaid(sweeper, piece, std::array{sweeper.last})) return;
    worker.push(piece);
  }

  // Tries to cull the triangle with the triangle of B nearest to its centroid, or near enough. Returns whether it did.
  bool owned_by_centroid(Sweeper& sweeper, Piece& piece, const Certificate& certificate) {
    SearchWorker& worker = sweeper.worker;
    const auto& [a, b, c] = piece.corners;
    const Vec3 centre = (a.point + b.point + c.point) / 3;
    const double radius = std::max({norm(a.point - centre), norm(b.point - centre), norm(c.point - centre)});
    const double enough = worker.cull_within_tolerance() - radius;  // a triangle of B so near to the centre culls
    sweeper.last = nearest_corner(search_.to(), centre, worker.work(), search_.stop(), sweeper.last, enough).slot;
    piece.upper = std::min(piece.upper, certificate(sweeper.last, worker.work()));
    const bool culled = piece.upper <= worker.cull_within_tolerance();
    if (culled) sweeper.worker.drop(piece.triangle, piece.upper);
    sweeper.centroids.note(culled);
    return culled;
  }

  // Tries to cull the piece with the overlay bound, unless that has failed before. Returns whether it did.
  bool overlaid(Sweeper& sweeper, Piece& piece, std::span<const std::uint32_t> starts) {
    if (!sweeper.overlay || piece.overlay_failed) return false;
    SearchWorker& worker = sweeper.worker;
    const double limit = worker.cull_within_tolerance();
    const Overlay::Attempt attempt = sweeper.overlay->attempt(piece, starts, limit, kMaxVisits, worker.work());
    piece.overlay_failed = attempt.started && !attempt.upper;
    if (attempt.started) sweeper.overlays.note(attempt.upper.has_value());
    if (attempt.upper) sweeper.worker.drop(piece.triangle, *attempt.upper);
    return attempt.upper.has_value();
  }

  // The triangles of B that culled neighbours or are nearest to the corners, each once.
  Hints hints(const Sweeper& sweeper, const Triangle& triangle) const {
    Hints hints;
    hints.add(sweeper.last);
    for (const std::uint32_t v : triangle) hints.add(vertices_[v].slot());
    return hints;
  }

  // Tries to cull triangle t with triangles of B that need no query. Returns whether it did.
  bool culled_by_guess(Sweeper& sweeper, const Certificate& certificate, std::uint32_t t) {
    ++sweeper.guessed;
    const bool culled = sweeper.guesses.note(guess(sweeper, certificate, t));
    if (!culled) ++sweeper.uncertified;
    return culled;
  }
  bool guess(Sweeper& sweeper, const Certificate& certificate, std::uint32_t t) {
    const Triangle& triangle = search_.from().triangles[t];
    const std::uint32_t twin = twins_.empty() ? kNoTwin : twins_[t];
    if (twin != kNoTwin && sweeper.twins.promising()) {
      if (sweeper.twins.note(certified(sweeper, certificate, t, twin))) return true;
    }
    const std::uint32_t next = sweeper.last + 1;  // B is ordered along a curve like A; kNone has no successor
    if (next < search_.to().mesh().triangles.size() && sweeper.successors.promising()) {
      if (sweeper.successors.note(certified(sweeper, certificate, t, next))) return true;
    }
    const Hints known = hints(sweeper, triangle);
    return std::any_of(known.span().begin(), known.span().end(),
                       [&](std::uint32_t hint) { return certified(sweeper, certificate, t, hint); });
  }

  // Drops triangle t of A if triangle `slot` of B alone shows that it is within the tolerance. Returns whether it did.
  bool certified(Sweeper& sweeper, const Certificate& certificate, std::uint32_t t, std::uint32_t slot) {
    const double upper = certificate(slot, sweeper.worker.work());
    if (upper > sweeper.worker.cull_within_tolerance()) return false;
    sweeper.worker.drop(t, upper);
    sweeper.last = slot;
    for (const std::uint32_t v : search_.from().triangles[t]) vertices_[v].suggest(slot);
    return true;
  }

  void note(const Block& block) {
    for (std::size_t t = block.begin; t < block.end; ++t) search_.note(t, block.upper);
  }

  Corner measure(Sweeper& sweeper, std::uint32_t v, std::uint32_t triangle) {
    Vertex& vertex = vertices_[v];
    const Vec3& p = search_.from().positions[v];
    if (vertex.measured()) {
      ++sweeper.worker.work().cache_hits;
      return {p, vertex.distance(), vertex.slot()};
    }
    const std::uint32_t hint = vertex.slot() != Nearest::kNone ? vertex.slot() : sweeper.last;
    const Corner corner = nearest_corner(search_.to(), p, sweeper.worker.work(), search_.stop(), hint);
    vertex.set(corner.distance, corner.slot);
    sweeper.last = corner.slot;
    sweeper.worker.observe(corner, triangle, true);
    return corner;
  }

  Search& search_;
  const OrderedMesh& from_;
  const OrderedMesh& to_;
  const bool has_adjacency_ = search_.adjacency() != nullptr;  // of B, from the start
  LargeArray<std::uint32_t> twins_;                            // twins_by_number(): by triangle of A, or empty
  std::vector<Block> blocks_;
  std::vector<Vertex> vertices_;
  std::deque<Sweeper> sweepers_;  // one for each thread
};

}  // namespace

std::optional<Stop> sweep(Search& search, const OrderedMesh& from, const OrderedMesh& to) {
  return Sweep(search, from, to).run();
}

}  // namespace meshgauge
