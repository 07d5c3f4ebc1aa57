#include "server/http/upload.h"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>

#include "server/base/share.h"
#include "server/store/data_folder.h"

namespace meshgauge::server {
namespace {

constexpr std::size_t kMaxInMemory = std::size_t{256} << 10;

// The cause is in errno.
api::Problem not_stored() {
  return api::to_problem(store::storage_error(errno, "the upload cannot be written to the directory for uploads"));
}

// Opens the file again, for a process that must not change it. Invalid where /proc is not mounted.
Descriptor open_read_only(int file) {
  return Descriptor(::open(("/proc/self/fd/" + std::to_string(file)).c_str(), O_RDONLY | O_CLOEXEC));
}

}  // namespace

int open_unnamed_file(const std::string& directory) {
  const int file = ::open(directory.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != EINVAL)) return file;
  std::string path = directory + "/meshgauge-XXXXXX";  // overlay file systems have no O_TMPFILE
  const int named = ::mkostemp(path.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(path.c_str());
  return named;
}

bool ByteBudget::take(std::uint64_t bytes, const std::string& client) {
  const std::lock_guard lock(mutex_);
  const auto found = used_by_.find(client);
  const std::uint64_t own = found == used_by_.end() ? 0 : found->second;
  if (bytes > max_bytes_ - used_ || !within_share(own, max_bytes_ - used_)) return false;
  used_by_[client] = own + bytes;
  used_ += bytes;
  return true;
}

void ByteBudget::give(std::uint64_t bytes, const std::string& client) {
  const std::lock_guard lock(mutex_);
  const auto found = used_by_.find(client);
  if (found == used_by_.end()) return;
  used_ -= bytes;
  if ((found->second -= bytes) == 0) used_by_.erase(found);
}

std::uint64_t ByteBudget::used() const {
  const std::lock_guard lock(mutex_);
  return used_;
}

Upload::~Upload() {
  if (mapped_) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
  close_file();
  share_.budget->give(size_, share_.client);
}

void Upload::close_file() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

Upload::Refusal Upload::append(std::string_view piece) {
  if (!share_.budget->take(piece.size(), share_.client)) {
    return api::Problem{api::ProblemKind::overloaded,
                        "all uploads together are at their limit of " + std::to_string(share_.budget->max_bytes()) +
                            " bytes, or those of this client at its share of it; retry later"};
  }
  size_ += piece.size();
  if (file_ >= 0 || memory_.size() + piece.size() > kMaxInMemory) return spill(piece);
  if (memory_.empty())
    memory_.reserve(kMaxInMemory);  // a mapping of its own (server/base/heap.h): only written pages cost memory
  const auto* start = reinterpret_cast<const std::byte*>(piece.data());
  memory_.insert(memory_.end(), start, start + piece.size());
  return std::nullopt;
}

Upload::Refusal Upload::spill(std::string_view piece) {
  if (file_ < 0) {
    file_ = open_unnamed_file(temp_dir_);
    if (file_ < 0 || !write_all(file_, memory_)) return not_stored();
    memory_ = {};
  }
  return write_all(file_, std::as_bytes(std::span(piece))) ? Refusal() : not_stored();
}

Upload::Refusal Upload::finish(bool with_file) {
  bytes_ = memory_;
  if (file_ < 0) return std::nullopt;
  void* start = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, file_, 0);
  if (with_file) read_only_ = open_read_only(file_);
  close_file();  // the mapping keeps the file
  if (start == MAP_FAILED) return not_stored();
  mapped_ = true;
  bytes_ = {static_cast<const std::byte*>(start), static_cast<std::size_t>(size_)};
  return std::nullopt;
}

}  // namespace meshgauge::server
