#include "server/store/data_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace meshgauge::server::store {
namespace {

namespace fs = std::filesystem;

fs::path folder_of(const std::string& path) {
  const fs::path folder = (fs::path(path) / "").parent_path().parent_path();
  return folder.empty() ? "." : folder;
}

// The group of the folder that holds `path`, if that folder is shared.
std::optional<gid_t> sharing_group(const std::string& path) {
  struct stat folder {};
  if (::stat(folder_of(path).c_str(), &folder) != 0) return std::nullopt;
  const mode_t mode = folder.st_mode;
  if ((mode & S_IRWXG) != S_IRWXG || (mode & S_IWOTH) != 0) return std::nullopt;
  const bool inherited = (mode & S_ISGID) != 0 && (mode & S_IRWXO) == 0;
  return folder.st_gid == 0 || inherited ? std::optional(folder.st_gid) : std::nullopt;
}

// Gives the group the rights of the owner, if what this process has made is of that group.
void share(gid_t group, int made) {
  struct stat status {};
  if (::fstat(made, &status) != 0 || status.st_gid != group || status.st_uid != ::geteuid()) return;
  const mode_t rights = status.st_mode & ~static_cast<mode_t>(S_IFMT);
  const mode_t shared = rights | ((rights & S_IRWXU) >> 3U);
  if (shared != rights) (void)::fchmod(made, shared);  // if it fails, this user can use it all the same
}

std::string user_and_group(std::uint64_t user, std::uint64_t group) {
  return std::to_string(user) + ':' + std::to_string(group);
}

std::string octal(mode_t mode) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "%04o", mode & 07777U);
  return text.data();
}

// The path itself, or the first folder above it that can be seen.
std::string first_seen(const std::string& path, struct stat& status) {
  std::error_code failed;
  fs::path seen = fs::absolute(path, failed).lexically_normal();
  while (::stat(seen.c_str(), &status) != 0 && seen != seen.root_path()) seen = seen.parent_path();
  return seen.string();
}

std::string advice(const std::string& path) {
  struct stat status {};
  const std::string seen = first_seen(path, status), quoted = "'" + seen + "'";
  const std::string own = user_and_group(::geteuid(), ::getegid());
  const std::string owner = user_and_group(status.st_uid, status.st_gid);
  const std::string found = "; this process runs as user and group " + own + ", and " + quoted + " belongs to " +
                            owner + " with mode " + octal(status.st_mode);
  if (status.st_uid == ::geteuid() && (status.st_mode & S_IRWXU) == S_IRWXU) {
    return found +
           ", so a rule of the machine (SELinux, AppArmor) denies it: allow it there; docker and podman have "
           "':z' behind a volume for it";
  }
  const std::string folder = S_ISDIR(status.st_mode) ? quoted : "'" + folder_of(seen).string() + "'";
  const std::string other = status.st_uid == 0 ? "name another folder (MESHGAUGE_DATA_DIR)"
                                               : "run as its owner (docker run --user " + owner + ")";
  return found + ": " + other + ", or give it to this user (chown -R " + own + " " + folder +
         ") or to every user of group 0 (chgrp -R 0 " + folder + " && chmod -R g=u " + folder + ")";
}

std::string in_quotes(const std::string& path) { return "the data folder '" + path + "'"; }

// The parent folder; "a/b/" is the same as "a/b".
fs::path parent_of(const std::string& path, std::error_code& failed) {
  const fs::path full = fs::absolute(path, failed).lexically_normal();
  return full.has_filename() ? full.parent_path() : full.parent_path().parent_path();
}

Result<Done> make_data_folder(const std::string& path) {
  std::error_code failed;
  const fs::path parent = parent_of(path, failed);
  if (!failed) fs::create_directories(parent, failed);
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

bool means_full(int error_number) { return error_number == ENOSPC || error_number == EDQUOT || error_number == EFBIG; }

Error storage_error(int error_number, const std::string& what) {
  const ErrorCode code = means_full(error_number) ? ErrorCode::storage_full : ErrorCode::storage_unavailable;
  return {code, what + ": " + std::system_category().message(error_number), "", ""};
}

Result<bool> make_folder(const std::string& path) {
  const auto group = sharing_group(path);
  if (::mkdir(path.c_str(), 0700) != 0) {
    if (errno == EEXIST) return false;
    return access_error(errno, "the folder '" + path + "' cannot be made", folder_of(path));
  }
  if (group) {
    // By a descriptor: another member of the group may put a link in its place.
    if (const Descriptor made(::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)); made) {
      share(*group, made.get());
    }
  }
  return true;
}

Descriptor open_file(const std::string& path, int flags) {
  const auto group = (flags & O_CREAT) != 0 ? sharing_group(path) : std::nullopt;
  if (!group) return Descriptor(::open(path.c_str(), flags | O_CLOEXEC, 0600));
  // Any member of the group may have put a link there; and a file that exists keeps its rights.
  Descriptor made(::open(path.c_str(), flags | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0600));
  if (made) share(*group, made.get());
  if (made || errno != EEXIST || (flags & O_EXCL) != 0) return made;
  return Descriptor(::open(path.c_str(), (flags & ~O_CREAT) | O_NOFOLLOW | O_CLOEXEC));
}

Error access_error(int error_number, const std::string& what, const std::string& path) {
  Error error = storage_error(error_number, what);
  if (error_number == EACCES) error.message += advice(path);
  return error;
}

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
