#include "postgres_server.h"

#include <fcntl.h>
#include <pwd.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <thread>
#include <vector>

#include "api/base/digest.h"
#include "server/store/postgres/postgres_store.h"

namespace meshgauge::server::store {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

// PostgreSQL refuses to run as root.
const passwd* other_user() {
  if (::getuid() != 0) return nullptr;
  const passwd* user = ::getpwnam("postgres");
  return user != nullptr ? user : ::getpwnam("nobody");
}

[[noreturn]] void become(const std::vector<std::string>& command, const std::string& log) {
  if (const passwd* user = other_user()) {
    if (::setgid(user->pw_gid) != 0 || ::setuid(user->pw_uid) != 0) ::_exit(126);
  }
  ::prctl(PR_SET_PDEATHSIG, SIGQUIT);  // it ends with the tests, also when they are killed
  const int file = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0 || ::dup2(file, 1) < 0 || ::dup2(file, 2) < 0) ::_exit(126);
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);
  ::execv(arguments.front(), arguments.data());
  ::_exit(127);
}

pid_t launch(const std::vector<std::string>& command, const std::string& log) {
  const pid_t process = ::fork();
  if (process == 0) become(command, log);
  return process;
}

void run(const std::vector<std::string>& command, const std::string& log) {
  int status = 0;
  if (::waitpid(launch(command, log), &status, 0) < 0 || status != 0) {
    throw std::runtime_error(command.front() + " failed; see " + log);
  }
}

// Another user may not be able to enter the folder of the programs, so this one opens it. The programs find the rest by
// relative paths.
std::string within_reach(const std::string& programs, const std::string& folder) {
  if (other_user() == nullptr || programs.starts_with("/usr/")) return programs;
  const fs::path usr = fs::path(programs).parent_path().parent_path().parent_path().parent_path();
  for (const char* part : {"lib/postgresql", "share/postgresql"}) {
    fs::create_directories(fs::path(folder) / "usr" / part);
    fs::copy(usr / part, fs::path(folder) / "usr" / part,
             fs::copy_options::recursive | fs::copy_options::copy_symlinks);
  }
  return fs::path(folder) / "usr" / fs::relative(programs, usr);
}

// TMPDIR may be closed to another user.
fs::path place() {
  const fs::path own = fs::temp_directory_path();
  const bool is_open = (fs::status(own).permissions() & fs::perms::sticky_bit) != fs::perms::none;
  return other_user() == nullptr || is_open ? own : fs::path("/tmp");
}

// Not a dead server that no test has requested.
bool runs(pid_t process) {
  std::ifstream status("/proc/" + std::to_string(process) + "/stat");
  std::string line;
  return std::getline(status, line) && line.find(") Z ") == std::string::npos;
}

std::unique_ptr<PgConnection> connect(const std::string& database) {
  for (int i = 0;; ++i) {
    try {
      return PgConnection::open(database);
    } catch (const PgFailure& failure) {
      if (i == 200) throw std::runtime_error("no connection: " + failure.message);
    }
    std::this_thread::sleep_for(50ms);
  }
}

}  // namespace

std::string PostgresServer::programs() {
  if (const char* given = std::getenv("MESHGAUGE_POSTGRES")) return given;
  std::string newest;
  for (const std::string root : {MESHGAUGE_BINARY_DIR "/tools/usr/lib/postgresql", "/usr/lib/postgresql"}) {
    std::error_code none;
    for (const auto& version : fs::directory_iterator(root, none)) {
      const std::string found = version.path() / "bin";
      if (fs::exists(found + "/initdb") && fs::exists(found + "/postgres")) newest = std::max(newest, found);
    }
  }
  return newest;
}

PostgresServer& PostgresServer::shared() {
  static PostgresServer server;
  return server;
}

PostgresServer::PostgresServer() : folder_(place() / ("meshgauge-postgres-" + api::random_id().substr(0, 8))) {
  fs::create_directory(folder_);
  if (const passwd* user = other_user()) {
    if (::chown(folder_.c_str(), user->pw_uid, user->pw_gid) != 0) throw std::runtime_error("chown failed");
  }
  programs_ = within_reach(programs(), folder_);
  run({programs_ + "/initdb", "-D", folder_ + "/data", "-U", "tests", "-A", "trust", "-E", "UTF8", "--locale=C",
       "--no-sync", "--no-instructions"},
      folder_ + "/log");
  start();
}

PostgresServer::~PostgresServer() {
  if (process_ > 0) kill();
  fs::remove_all(folder_);
}

void PostgresServer::start() {
  process_ = launch({programs_ + "/postgres", "-D", folder_ + "/data", "-k", folder_, "-c", "listen_addresses=", "-c",
                     "fsync=off", "-c", "max_connections=200", "-c", "shared_buffers=64MB"},
                    folder_ + "/log");
  connect(connection_string("postgres"));
}

void PostgresServer::stop() {
  ::kill(process_, SIGINT);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
}

// PostgreSQL's processes have sessions of their own. A new server refuses the folder until the last process has ended.
void PostgresServer::kill() {
  std::vector<pid_t> all{process_};
  std::ifstream children("/proc/" + std::to_string(process_) + "/task/" + std::to_string(process_) + "/children");
  for (pid_t child = 0; children >> child;) all.push_back(child);
  for (const pid_t one : all) ::kill(one, SIGKILL);
  ::waitpid(process_, nullptr, 0);
  process_ = -1;
  for (const pid_t one : all) {
    while (runs(one)) std::this_thread::sleep_for(5ms);
  }
}

std::string PostgresServer::connection_string(const std::string& database) const {
  return "host=" + folder_ + " user=tests dbname=" + database;
}

void PostgresServer::execute(const std::string& sql) { connect(connection_string("postgres"))->execute(sql); }

std::string PostgresServer::new_empty_database() {
  const std::string name = "d" + std::to_string(++databases_);
  execute("CREATE DATABASE " + name + " TEMPLATE template0 STRATEGY file_copy");
  return connection_string(name);
}

std::string PostgresServer::new_database() {
  if (!has_template_) {
    execute("CREATE DATABASE ours");
    const auto migrated = migrate_database(connection_string("ours"));
    if (!migrated) throw std::runtime_error(migrated.error().message);
    has_template_ = true;
  }
  const std::string name = "d" + std::to_string(++databases_);
  execute("CREATE DATABASE " + name + " TEMPLATE ours STRATEGY file_copy");
  return connection_string(name);
}

void PostgresServer::drop(const std::string& connection_string) {
  const std::string name = connection_string.substr(connection_string.rfind('=') + 1);
  execute("DROP DATABASE " + name + " WITH (FORCE)");
}

}  // namespace meshgauge::server::store
