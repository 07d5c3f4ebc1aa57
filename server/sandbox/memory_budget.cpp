#include "server/sandbox/memory_budget.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "api/compare/load.h"
#include "engine/mesh.h"

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kMemoryTick{10};
constexpr std::uint64_t kLeastReader = std::uint64_t{32} << 20;

// Given positions, those in order and those in another unit; given triangles, those in order, their tree and tables.
// For a closed mesh, of half as many vertices as triangles, it is 176 bytes a triangle.
constexpr std::uint64_t kBytesOfVertex = 72;
constexpr std::uint64_t kBytesOfTriangle = 140;

Error too_large(std::uint64_t bytes, std::uint64_t triangles, std::uint64_t most) {
  return {ErrorCode::too_large,
          "the comparison needs " + std::to_string(bytes) + " bytes of memory for " + std::to_string(triangles) +
              " triangles, more than the " + std::to_string(most) + " that one may have here; send smaller meshes",
          "", ""};
}

}  // namespace

std::uint64_t bytes_of_mesh(std::uint64_t vertices, std::uint64_t triangles) {
  return vertices * kBytesOfVertex + triangles * kBytesOfTriangle;
}

std::uint64_t MemoryBudget::reserved() const {
  const std::lock_guard lock(mutex_);
  return reserved_;
}

// Precondition of this and the next functions: mutex_ is held.
void MemoryBudget::count(std::uint64_t held, std::uint64_t bytes) {
  reserved_ += bytes - held;
  if (is_small(held)) of_small_ -= held;
  if (is_small(bytes)) of_small_ += bytes;
}

// Whether a reservation of `held` may become one of `bytes`, as far as the others leave room.
bool MemoryBudget::fits(std::uint64_t held, std::uint64_t bytes) const {
  const bool was_small = is_small(held);
  if (reserved_ - held + bytes > bytes_) return false;
  if (!is_small(bytes)) return reserved_ - of_small_ - (was_small ? 0 : held) + bytes <= most_of_a_job();
  const bool large_wait = std::any_of(waiting_.begin(), waiting_.end(), [&](auto other) { return !is_small(other); });
  return !large_wait || of_small_ - (was_small ? held : 0) + bytes <= bytes_ / kForSmall;
}

// Whether another job of its kind, small or large, waits before `end`.
bool MemoryBudget::is_behind(std::uint64_t bytes, Waiting::const_iterator end) const {
  return std::any_of(waiting_.begin(), end, [&](auto other) { return is_small(other) == is_small(bytes); });
}

// Makes a reservation of `held` one of `bytes`. False: it stays, since that is more than there is, or others wait.
bool MemoryBudget::change(std::uint64_t held, std::uint64_t bytes, bool of_second) {
  const std::lock_guard lock(mutex_);
  const bool is_spare = waiting_.empty() && reserved_ - held + bytes <= bytes_ - bytes_ / kForFirst;
  if (bytes > held && (is_behind(bytes, waiting_.end()) || !fits(held, bytes) || (of_second && !is_spare)))
    return false;
  count(held, bytes);
  if (bytes < held) freed_.notify_all();
  return true;
}

// Makes two reservations one.
void MemoryBudget::join(std::uint64_t held, std::uint64_t other) {
  const std::lock_guard lock(mutex_);
  count(held, held + other);
  count(other, 0);
}

Interruption MemoryBudget::wait(std::uint64_t bytes, Control& control) {
  std::unique_lock lock(mutex_);
  const auto self = waiting_.insert(waiting_.end(), bytes);
  Interruption why = Interruption::none;
  while (is_behind(bytes, self) || !fits(0, bytes)) {
    if ((why = control.check()) != Interruption::none) break;
    freed_.wait_for(lock, kMemoryTick);
  }
  waiting_.erase(self);
  if (why == Interruption::none) count(0, bytes);
  freed_.notify_all();  // another job is the next one
  return why;
}

MemoryReservation::~MemoryReservation() { budget_.change(reserved_, 0); }

Result<Done> MemoryReservation::wait_for_turn() {
  if (of_second_) return begin_again(0);
  return Done{};
}

Result<Done> MemoryReservation::begin(Control& control) {
  budget_.change(reserved_, 0);
  reserved_ = reader_ = 0;
  meshes_ = read_ = {};
  restart_ = false;
  if (planned_ == 0) return Done{};
  const Interruption why = budget_.wait(planned_, control);
  if (why != Interruption::none) return api::not_in_time(why, "there was memory for it");
  reserved_ = planned_;
  return Done{};
}

// A reader that gets all there is leaves room for the copy of its mesh, where that is known.
Result<std::uint64_t> MemoryReservation::take_reader(std::uint64_t bytes) {
  meshes_ = read_;
  const std::uint64_t most = budget_.most_of_a_job();
  const std::uint64_t copied = meshes_.number < copied_.size() ? copied_[meshes_.number] : 0;
  const std::uint64_t taken = meshes_.arrays + copied;
  const std::uint64_t granted = std::min(bytes, most - std::min(most, taken));
  if (granted < std::min(bytes, kLeastReader)) return never(meshes_.arrays + bytes);
  if (auto ok = need(granted, meshes_.arrays); !ok) return ok.error();
  return granted;
}

void MemoryReservation::end_reader() {
  read_ = meshes_;
  if (!restart_) static_cast<void>(need(0, meshes_.arrays));  // less always fits
}

// While the mesh is copied, its reader is there; what measuring makes of the mesh comes when the reader has gone. So
// the larger of the two counts. A mesh that fits alone, and not beside its reader, is read again by a smaller one.
Result<Done> MemoryReservation::take_mesh(std::uint64_t vertices, std::uint64_t triangles) {
  const std::uint64_t copied = vertices * sizeof(Vec3) + triangles * sizeof(Triangle);
  const std::uint64_t arrays = meshes_.arrays + bytes_of_mesh(vertices, triangles);
  const std::uint64_t both = std::max(arrays, meshes_.arrays + reader_ + copied);
  const bool first = meshes_.number == copied_.size();
  const bool is_read = reader_ == 0;  // already, by an earlier job
  if (first) copied_.push_back(copied);
  ++meshes_.number;
  meshes_.triangles += triangles;
  const std::uint64_t most = budget_.most_of_a_job();
  if (first && arrays <= most && both > most) return begin_again(most);
  Result<Done> taken = need(both - arrays, arrays);
  if (taken && is_read) read_ = meshes_;
  return taken;
}

Result<Done> MemoryReservation::take_more(std::uint64_t bytes) { return need(0, meshes_.arrays + bytes); }

// No other job gets the memory in between.
Result<Done> MemoryReservation::take_over(MemoryReservation& second) {
  budget_.join(reserved_, second.reserved_);
  reserved_ += std::exchange(second.reserved_, 0);
  const Meshes taken = std::exchange(second.meshes_, {});
  if (taken.number == 0) return Done{};
  if (copied_.size() == meshes_.number) copied_.push_back(second.copied_.front());
  meshes_.number += taken.number;
  meshes_.triangles += taken.triangles;
  Result<Done> fits = need(0, meshes_.arrays + taken.arrays);
  read_ = meshes_;
  return fits;
}

void MemoryReservation::keep_meshes() {
  budget_.change(reserved_, meshes_.arrays);
  reserved_ = meshes_.arrays;
}

// What was waited for is kept until all is known, so that the next step fits as well.
Result<Done> MemoryReservation::need(std::uint64_t reader, std::uint64_t arrays) {
  const std::uint64_t all = reader + arrays;
  if (all > budget_.most_of_a_job()) return never(all);
  const std::uint64_t wanted = std::max(planned_, all);
  if (!budget_.change(reserved_, wanted, of_second_)) return begin_again(wanted);
  reserved_ = wanted;
  reader_ = reader;
  meshes_.arrays = arrays;
  return Done{};
}

Error MemoryReservation::never(std::uint64_t bytes) {
  if (of_second_) return begin_again(0);
  return too_large(bytes, meshes_.triangles, budget_.most_of_a_job());
}

Error MemoryReservation::begin_again(std::uint64_t planned) {
  restart_ = true;
  planned_ = planned;
  return {ErrorCode::internal, "not enough memory for the comparison now", "", ""};
}

}  // namespace meshgauge::server
