#include "server/store/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <utility>

#include "server/store/errors.h"
#include "server/store/rights.h"

namespace meshgauge::server::store {
namespace {

std::string in_quotes(const std::string& path) { return "the data folder '" + path + "'"; }

// The parent folder; "a/b/" is the same as "a/b".
std::filesystem::path parent_of(const std::string& path, std::error_code& failed) {
  const std::filesystem::path full = std::filesystem::absolute(path, failed).lexically_normal();
  return full.has_filename() ? full.parent_path() : full.parent_path().parent_path();
}

Result<Done> make_data_folder(const std::string& path) {
  std::error_code failed;
  const std::filesystem::path parent = parent_of(path, failed);
  if (!failed) std::filesystem::create_directories(parent, failed);
  if (failed) return access_error(failed.value(), in_quotes(path) + " cannot be made", parent.string());
  Result<bool> made = make_folder(path);
  if (!made) return made.error();
  return *made ? sync_folder(parent) : Result<Done>(Done{});
}

std::string holder_of(const Descriptor& lock) {
  std::array<char, 32> text{};
  const ssize_t length = ::pread(lock.get(), text.data(), text.size(), 0);
  std::string number(text.data(), length > 0 ? static_cast<std::size_t>(length) : 0);
  number.erase(number.find_last_not_of('\n') + 1);
  return number.empty() ? "" : " (" + number + ")";
}

// For operators alone: on a full disk the lock holds without this content.
void write_number(const Descriptor& lock) {
  const std::string number = std::to_string(::getpid()) + "\n";
  if (::ftruncate(lock.get(), 0) != 0 || ::pwrite(lock.get(), number.data(), number.size(), 0) < 0) return;
}

}  // namespace

Result<Done> sync_folder(const std::string& path) {
  const Descriptor folder(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder || ::fsync(folder.get()) != 0) {
    return storage_error(errno, "the folder '" + path + "' cannot be written to");
  }
  return Done{};
}

Result<DataFolder> DataFolder::open(const std::string& path) {
  Result<Done> made = make_data_folder(path);
  if (!made) return made.error();
  const std::string file = path + "/lock";
  Descriptor lock = open_file(file, O_RDWR | O_CREAT);
  if (!lock) return access_error(errno, in_quotes(path) + " cannot be used", file);
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) return storage_error(errno, in_quotes(path) + " cannot be locked");
    return Error{ErrorCode::storage_unavailable,
                 in_quotes(path) + " is used by another process" + holder_of(lock) + "; each needs its own", "", ""};
  }
  write_number(lock);
  return DataFolder(path, std::move(lock));
}

}  // namespace meshgauge::server::store
