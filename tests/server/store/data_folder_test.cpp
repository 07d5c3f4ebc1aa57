#include "server/store/data_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include <cerrno>
#include <string>

#include "test_folder.h"

using namespace meshgauge;
using namespace meshgauge::server::store;

namespace {

mode_t mode_of(const std::string& path) {
  struct stat status {};
  REQUIRE(::stat(path.c_str(), &status) == 0);
  return status.st_mode & 07777U;
}

// Modes of a folder and a file that are made in a folder with this mode, of this process's own group.
struct Made {
  mode_t folder;
  mode_t file;
};

Made made_in(const std::string& folder, mode_t mode) {
  REQUIRE(::chmod(folder.c_str(), mode) == 0);
  const std::string inner = folder + "/inner", file = folder + "/file";
  REQUIRE(make_folder(inner).value());
  CHECK_FALSE(make_folder(inner).value());
  REQUIRE(open_file(file, O_RDWR | O_CREAT | O_EXCL));
  const Made made{mode_of(inner), mode_of(file)};
  ::rmdir(inner.c_str());
  ::unlink(file.c_str());
  return made;
}

}  // namespace

TEST_CASE("rights: in a shared folder no link is followed, and what exists keeps its rights") {
  const TestFolder folder;
  REQUIRE(::chmod(folder.path().c_str(), 02770) == 0);
  const TestFolder elsewhere;
  const std::string victim = elsewhere.path() + "/victim", link = folder.path() + "/link";
  REQUIRE(open_file(victim, O_RDWR | O_CREAT));
  REQUIRE(::symlink(victim.c_str(), link.c_str()) == 0);
  CHECK_FALSE(open_file(link, O_RDWR | O_CREAT));
  CHECK(errno == ELOOP);
  CHECK(mode_of(victim) == 0600);
  const std::string own = folder.path() + "/own";
  REQUIRE(open_file(own, O_RDWR | O_CREAT));
  CHECK(mode_of(own) == 0660);
  REQUIRE(::chmod(own.c_str(), 0600) == 0);
  CHECK(open_file(own, O_RDWR | O_CREAT));
  CHECK(mode_of(own) == 0600);
}

TEST_CASE("rights: what is made in a shared folder is shared, whatever the umask is") {
  const TestFolder folder;
  const mode_t before = ::umask(077);
  const Made made = made_in(folder.path(), 02770);
  ::umask(before);
  CHECK(made.folder == 02770);
  CHECK(made.file == 0660);
}

TEST_CASE("rights: elsewhere it is the owner's alone") {
  const TestFolder folder;
  for (const mode_t mode : {0700U, 0750U, 0777U, 02777U, 01777U}) {
    CAPTURE(mode);
    const Made made = made_in(folder.path(), mode);
    CHECK((made.folder & 0777U) == 0700);
    CHECK(made.file == 0600);
  }
}

TEST_CASE("rights: a file that exists keeps what another mode gave it, outside of a shared folder") {
  const TestFolder folder;
  const std::string path = folder / "file";
  REQUIRE(open_file(path, O_RDWR | O_CREAT));
  REQUIRE(::chmod(path.c_str(), 0640) == 0);
  CHECK(open_file(path, O_RDWR | O_CREAT));
  CHECK(mode_of(path) == 0640);
  CHECK_FALSE(open_file(folder / "none", O_RDONLY));
}

TEST_CASE("rights: a denial names both users, the mode and what to do, another failure does not") {
  const TestFolder folder;
  const std::string path = folder.path(), file = folder / "none/lock";
  REQUIRE(::chmod(path.c_str(), 0500) == 0);
  const auto error = access_error(EACCES, "it cannot be used", file);
  const std::string own = std::to_string(::geteuid()) + ":" + std::to_string(::getegid());
  CHECK(error.message.find("it cannot be used: Permission denied; this process runs as user and group " + own +
                           ", and '" + path + "' belongs to " + own + " with mode 0500: ") == 0);
  CHECK(error.message.find("chgrp -R 0 '" + path + "' && chmod -R g=u '" + path + "'") != std::string::npos);
  REQUIRE(::chmod(path.c_str(), 0700) == 0);
  CHECK(access_error(EACCES, "it", file).message.find("SELinux") != std::string::npos);
  CHECK(access_error(EROFS, "it", file).message == "it: Read-only file system");
}
