// The streams of EXT_meshopt_compression and KHR_meshopt_compression: a byte that chooses the mode, two of the count,
// one of the stride, then the stream. Asserted: libmeshoptimizer takes it as well, or refuses it as well, and gives the
// same bytes. Its older versions do not know version 1 of attributes; there only a crash is a finding.
#include <vector>

#include <meshoptimizer.h>

#include "api/formats/gltf/meshopt.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace meshgauge;

struct Input {
  unsigned mode = 0;
  std::size_t count = 0;
  std::size_t stride = 0;
  std::vector<unsigned char> stream;

  bool decode(std::span<std::byte> out) const {
    const auto bytes = std::as_bytes(std::span(stream));
    if (mode == 0) return api::decode_meshopt_attributes(bytes, stride, out);
    return mode == 1 ? api::decode_meshopt_triangles(bytes, stride, out)
                     : api::decode_meshopt_indices(bytes, stride, out);
  }

  bool decode_by_peer(unsigned char* out) const {
    if (mode == 0) return meshopt_decodeVertexBuffer(out, count, stride, stream.data(), stream.size()) == 0;
    return (mode == 1 ? meshopt_decodeIndexBuffer(out, count, stride, stream.data(), stream.size())
                      : meshopt_decodeIndexSequence(out, count, stride, stream.data(), stream.size())) == 0;
  }

  bool is_beyond_peer() const { return mode == 0 && !stream.empty() && stream[0] != 0xA0; }
};

}  // namespace

FUZZ_TARGET(meshopt) {
  if (size < 4) return 0;
  Input input;
  input.mode = data[0] % 3U;
  input.count = data[1] + 256U * (data[2] % 16U);
  input.stride = input.mode == 0 ? 4U * (data[3] % 64U + 1U) : 2U + 2U * (data[3] % 2U);
  if (input.mode == 1) input.count -= input.count % 3;
  input.stream.assign(data + 4, data + size);
  std::vector<unsigned char> ours(input.count * input.stride);
  std::vector<unsigned char> theirs(ours.size());
  const bool taken = input.decode(std::as_writable_bytes(std::span(ours)));
  if (taken && input.mode == 0) {
    auto filtered = ours;
    api::undo_meshopt_exponential(std::as_writable_bytes(std::span(filtered)));
    filtered.resize(filtered.size() / 8 * 8);
    api::undo_meshopt_quaternion(std::as_writable_bytes(std::span(filtered)));
  }
  if (input.is_beyond_peer()) return 0;
  fuzz::require(taken == input.decode_by_peer(theirs.data()), "libmeshoptimizer takes the same streams");
  fuzz::require(!taken || ours == theirs, "libmeshoptimizer gives the same bytes");
  return 0;
}
