#include "engine/tree/prepared.h"

#include <algorithm>

namespace meshgauge {
namespace {

// Returns `made`, or null if it is not complete.
template <class T>
std::unique_ptr<const T> if_complete(std::unique_ptr<const T> made) {
  if (!made->complete()) made.reset();
  return made;
}

template <class T>
std::size_t bytes_if_made(const Lazy<T>& made) {
  const T* known = made.peek();
  return known ? known->bytes() : 0;
}

Interrupted asking(Control& control) {
  return [&control] { return control.check() != Interruption::none; };
}

}  // namespace

const OrderedMesh* Framed::order(Control& control, ThreadPool& pool) {
  return order_.get(asking(control), [&] {
    return if_complete(
        std::make_unique<const OrderedMesh>(given_, std::span<const std::uint32_t>(), box_, frame_, control, pool));
  });
}

const Bvh* Framed::tree(Control& control, ThreadPool& pool) {
  const OrderedMesh* ordered = order(control, pool);
  if (!ordered) return nullptr;
  return tree_.get(asking(control),
                   [&] { return if_complete(std::make_unique<const Bvh>(ordered->view(), kernels_, control, pool)); });
}

const Adjacency* Framed::adjacency(ThreadPool& pool, const Interrupted& interrupted) {
  return adjacency_.get(interrupted, [&] {
    return if_complete(std::make_unique<const Adjacency>(order_.peek()->view(), pool, interrupted));
  });
}

std::size_t Framed::bytes() const {
  return sizeof *this + bytes_if_made(order_) + bytes_if_made(tree_) + bytes_if_made(adjacency_);
}

const Box& Prepared::box() const {
  std::call_once(box_made_, [this] { box_ = bounding_box(mesh_); });
  return box_;
}

std::size_t Prepared::bytes() const {
  std::size_t bytes = sizeof *this + mesh_.positions.size_bytes() + mesh_.triangles.size_bytes() +
                      bytes_if_made(positions_) + bytes_if_made(triangles_);
  const std::lock_guard lock(mutex_);
  for (const auto& framed : frames_) bytes += framed ? framed->bytes() : 0;
  return bytes;
}

std::shared_ptr<Framed> Prepared::in(const Frame& frame, const Kernels& kernels) const {
  const Box& of_mesh = box();
  std::shared_ptr<Framed> replaced;  // destroyed after the lock is released
  const std::lock_guard lock(mutex_);
  auto found = std::find_if(frames_.begin(), frames_.end(), [&](const auto& framed) {
    return framed && &framed->kernels() == &kernels && framed->frame() == frame;
  });
  if (found == frames_.end()) {
    --found;
    replaced = std::exchange(*found, std::make_shared<Framed>(mesh_, of_mesh, frame, kernels));
  }
  std::rotate(frames_.begin(), found, found + 1);
  return frames_.front();
}

const PositionIndex* Prepared::positions(const Interrupted& interrupted) const {
  return positions_.get(interrupted,
                        [&] { return if_complete(std::make_unique<const PositionIndex>(mesh_, interrupted)); });
}

const TriangleIndex* Prepared::triangles(const Interrupted& interrupted) const {
  return triangles_.get(interrupted,
                        [&] { return if_complete(std::make_unique<const TriangleIndex>(mesh_, interrupted)); });
}

}  // namespace meshgauge
