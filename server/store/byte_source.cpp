#include "server/store/byte_source.h"

#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <vector>

#include "server/store/errors.h"

namespace meshgauge::server::store {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 20;

}  // namespace

ByteSource ByteSource::part(std::uint64_t offset, std::uint64_t size) const {
  assert(offset + size <= size_);
  ByteSource part = *this;
  if (file_ < 0) part.bytes_ = bytes_.subspan(offset, size);
  part.begin_ += offset;
  part.size_ = size;
  return part;
}

Result<std::size_t> ByteSource::read(std::uint64_t offset, std::span<std::byte> into) const {
  const std::size_t wanted = std::min<std::uint64_t>(into.size(), size_ - std::min(offset, size_));
  if (file_ < 0) {
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), wanted, into.begin());
    return wanted;
  }
  for (std::size_t done = 0; done < wanted;) {
    const ssize_t n = ::pread(file_, into.data() + done, wanted - done, static_cast<off_t>(begin_ + offset + done));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return storage_error(errno, "the upload cannot be read");
    if (n == 0)
      return Error{ErrorCode::internal, "the upload became shorter while it was stored; send it again", "", ""};
    done += static_cast<std::size_t>(n);
  }
  return wanted;
}

Result<std::string> ByteSource::sha256_hex(api::Sha256* whole) const {
  api::Sha256 digest;
  std::vector<std::byte> buffer(file_ < 0 ? 0 : std::min<std::uint64_t>(size_, kPiece));
  for (std::uint64_t done = 0; done < size_;) {
    std::span<const std::byte> piece = file_ < 0 ? bytes_ : buffer;
    if (file_ >= 0) {
      Result<std::size_t> n = read(done, buffer);
      if (!n) return n.error();
      piece = piece.first(*n);
    }
    digest.update(piece);
    if (whole != nullptr) whole->update(piece);
    done += piece.size();
  }
  return digest.hex();
}

}  // namespace meshgauge::server::store
