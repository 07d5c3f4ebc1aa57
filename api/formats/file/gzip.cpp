#include "api/formats/file/gzip.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <zlib.h>

#include "api/formats/file/source.h"

namespace meshgauge::api {
namespace {

constexpr std::size_t kFirstBytes = std::size_t{64} << 10U;

class Inflater {
 public:
  Inflater(std::span<const std::byte> bytes, std::string_view part, const ReadLimits& limits)
      : input_(bytes), part_(part), limit_(expansion_limit(bytes.size(), limits)) {
    constexpr int kGzipOnly = 15 + 16;
    ready_ = inflateInit2(&stream_, kGzipOnly) == Z_OK;
  }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;
  ~Inflater() {
    if (ready_) inflateEnd(&stream_);
  }

  Result<Expanded> run(const FirstLook& first_look);

 private:
  bool grow();
  std::optional<Error> step();
  std::optional<Error> end_of_member();
  void feed();
  Error fail(ErrorCode code, const std::string& what) const {
    const ReadLimits unused;
    return at_byte(Source{input_, part_, unused}, read_ - stream_.avail_in, code, what);
  }

  std::span<const std::byte> input_;
  std::string_view part_;
  std::size_t limit_;
  std::size_t read_ = 0;  // bytes of the input passed to zlib so far
  std::size_t capacity_ = 0;
  bool ready_ = false;
  bool done_ = false;
  z_stream stream_{};
  Expanded out_;
};

// Doubles the capacity, up to one byte over the limit, to tell "at the limit" from "over the limit". realloc remaps the
// pages of large blocks without copying.
bool Inflater::grow() {
  const std::size_t wanted = std::min(std::max(kFirstBytes, 2 * capacity_), limit_ + 1);
  auto* moved = static_cast<std::byte*>(std::realloc(out_.data.get(), wanted));
  if (moved == nullptr) return false;
  static_cast<void>(out_.data.release());
  out_.data.reset(moved);
  capacity_ = wanted;
  return true;
}

// Passes input to zlib in pieces, since zlib counts in 32 bits.
void Inflater::feed() {
  constexpr std::size_t kMostAtOnce = std::size_t{1} << 30U;
  if (stream_.avail_in != 0) return;
  const std::size_t count = std::min(input_.size() - read_, kMostAtOnce);
  stream_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input_.data() + read_));  // zlib reads only
  stream_.avail_in = static_cast<uInt>(count);
  read_ += count;
}

std::optional<Error> Inflater::end_of_member() {
  feed();
  if (stream_.avail_in == 0) {
    done_ = true;
    return std::nullopt;
  }
  if (*stream_.next_in != 0x1F) return fail(ErrorCode::unreadable_mesh, "left-over bytes after the gzip data");
  inflateReset(&stream_);
  return std::nullopt;
}

std::optional<Error> Inflater::step() {
  feed();
  const std::size_t room = std::min<std::size_t>(capacity_ - out_.size, std::numeric_limits<uInt>::max());
  stream_.next_out = reinterpret_cast<Bytef*>(out_.data.get() + out_.size);
  stream_.avail_out = static_cast<uInt>(room);
  const int status = inflate(&stream_, Z_NO_FLUSH);
  out_.size += room - stream_.avail_out;
  if (out_.size > limit_) return expands_too_far(part_, limit_, input_.size(), "gzip");
  if (status == Z_STREAM_END) return end_of_member();
  if (status == Z_OK) return std::nullopt;
  if (status == Z_BUF_ERROR) {
    if (stream_.avail_out == 0) return std::nullopt;
    return fail(ErrorCode::unreadable_mesh, "truncated: the gzip data end too early");
  }
  const std::string reason = stream_.msg != nullptr ? stream_.msg : "unknown fault";
  return fail(ErrorCode::unreadable_mesh, "damaged gzip data: " + reason);
}

Result<Expanded> Inflater::run(const FirstLook& first_look) {
  if (!ready_) return about(part_, ErrorCode::internal, "could not be expanded: zlib does not start");
  bool looked = false;
  while (!done_) {
    if (out_.size == capacity_ && !grow()) {
      return out_of_memory(part_);
    }
    if (auto error = step()) return std::move(*error);
    if (!looked && (done_ || out_.size >= kFirstBytes)) {
      looked = true;
      if (auto error = first_look(out_.bytes())) return std::move(*error);
    }
  }
  return std::move(out_);
}

}  // namespace

bool is_gzip(std::span<const std::byte> bytes) {
  return bytes.size() >= 2 && bytes[0] == std::byte{0x1F} && bytes[1] == std::byte{0x8B};
}

Result<Expanded> expand_gzip(std::span<const std::byte> bytes, std::string_view part, const ReadLimits& limits,
                             const FirstLook& first_look) {
  return Inflater(bytes, part, limits).run(first_look);
}

}  // namespace meshgauge::api
