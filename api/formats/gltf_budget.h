// Limits the cost of reading one glTF by the size sent: of the file, or of the archive with the files beside it.
#pragma once

#include <cstddef>
#include <string>

#include "api/formats/source.h"

namespace meshgauge::api {

class GltfBudget {
 public:
  // Borrows `sent`, the file or the archive; its size sets the limits. Buffers that share bytes and entries that an
  // archive expands do not raise them.
  explicit GltfBudget(const Source& sent);

  // Charges bytes that compressed parts expand to; bytes decompressed twice count twice. Error: too_large once their
  // sum exceeds expansion_limit().
  Result<Done> take(std::size_t bytes);

  // Returns true when elements without bytes in the file may temporarily take so much memory.
  bool fits(std::size_t bytes) const { return bytes <= most_bytes_; }

  // Charges steps of a few nanoseconds each: an element read, a corner placed. Error, naming `where`: their sum exceeds
  // kFreeSteps + kStepsPerByte * bytes sent. Nodes, instances, primitives and targets of a small file may read its few
  // numbers millions of times.
  Result<Done> work(std::size_t steps, const std::string& where);

  // Refunds up to kStepsPerTriangle for each triangle added to the mesh since steps() was `since`: max_triangles
  // already bounds that work.
  void refund(std::size_t since, std::size_t triangles);

  std::size_t steps() const { return steps_; }

  static constexpr std::size_t kFreeSteps = std::size_t{1} << 27;
  static constexpr std::size_t kStepsPerByte = 16;
  static constexpr std::size_t kStepsPerTriangle = 32;

 private:
  const Source& sent_;
  std::size_t most_bytes_;
  std::size_t most_steps_;
  std::size_t bytes_ = 0;
  std::size_t steps_ = 0;
};

}  // namespace meshgauge::api
