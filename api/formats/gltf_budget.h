// What the reading of one glTF may cost, by the size of what was sent: the file, or the archive with the files beside
// it.
#pragma once

#include <cstddef>
#include <string>

#include "api/formats/source.h"

namespace meshgauge::api {

class GltfBudget {
 public:
  // `sent`: the file or the archive, borrowed. Buffers that name the same bytes twice, and bytes that an archive
  // expands, add nothing to it.
  explicit GltfBudget(const Source& sent);

  // Takes bytes that compressed parts expand to, or refuses once they pass expansion_limit() together. What is
  // decompressed twice counts twice.
  Result<Done> take(std::size_t bytes);

  // Whether elements that have no bytes in the file may take so much memory for a moment.
  bool fits(std::size_t bytes) const { return bytes <= most_bytes_; }

  // Takes steps of a few nanoseconds: an element that is read, a corner that is placed. Refuses with `where` once they
  // pass kFreeSteps and kStepsPerByte for each byte sent. For the few numbers of a file may be asked for millions of
  // times: by nodes, instances, primitives, targets.
  Result<Done> work(std::size_t steps, const std::string& where);

  // Gives back up to kStepsPerTriangle for each triangle that the work since steps() == `since` has put into the mesh:
  // max_triangles bounds these.
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
