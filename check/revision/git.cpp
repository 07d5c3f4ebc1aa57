#include "check/revision/git.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <memory>
#include <utility>

#include "api/base/descriptor.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostWords = 400;  // of what git says of a failure

struct StreamClosed {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stream = std::unique_ptr<std::FILE, StreamClosed>;

constexpr std::chrono::minutes kMostTime{10};  // of a command
constexpr int kTickMs = 20;                    // interval at which a command is looked after

// Nothing that the folder names is run or fetched: a repository within another one may be files that a stranger has
// committed, and a '.git' may come from an archive.
constexpr std::array<const char*, 2> kOnlyRealRepositories{"-c", "safe.bareRepository=explicit"};
constexpr std::array<std::string_view, 4> kVariables{"GIT_TERMINAL_PROMPT=0", "LC_ALL=C", "GIT_ALLOW_PROTOCOL=none",
                                                     "GIT_NO_LAZY_FETCH=1"};

// What leads git to another repository than that of the folder, or has it write elsewhere; `git rev-parse
// --local-env-vars` lists the former, and configuration, which is passed on.
constexpr std::array<std::string_view, 13> kOfOtherRepositories{"GIT_ALTERNATE_OBJECT_DIRECTORIES",
                                                                "GIT_OBJECT_DIRECTORY",
                                                                "GIT_DIR",
                                                                "GIT_WORK_TREE",
                                                                "GIT_GRAFT_FILE",
                                                                "GIT_INDEX_FILE",
                                                                "GIT_IMPLICIT_WORK_TREE",
                                                                "GIT_PREFIX",
                                                                "GIT_NO_REPLACE_OBJECTS",
                                                                "GIT_REPLACE_REF_BASE",
                                                                "GIT_SHALLOW_FILE",
                                                                "GIT_COMMON_DIR",
                                                                "GIT_INTERNAL_SUPER_PREFIX"};

std::string_view name_of_variable(std::string_view variable) { return variable.substr(0, variable.find('=')); }

bool is_passed_on(std::string_view variable) {
  const std::string_view name = name_of_variable(variable);
  return std::ranges::find(kOfOtherRepositories, name) == kOfOtherRepositories.end() &&
         std::ranges::find(kVariables, name, name_of_variable) == kVariables.end() && !name.starts_with("GIT_TRACE");
}

std::vector<std::string> environment_of_git() {
  std::vector<std::string> variables(kVariables.begin(), kVariables.end());
  for (char** variable = environ; variable && *variable; ++variable) {
    if (is_passed_on(*variable)) variables.emplace_back(*variable);
  }
  return variables;
}

std::vector<char*> arguments_of(std::vector<std::string>& texts) {
  std::vector<char*> all;
  all.reserve(texts.size() + 1);
  for (std::string& text : texts) all.push_back(text.data());
  all.push_back(nullptr);
  return all;
}

Error git_failed(const std::string& why) { return {ErrorCode::internal, "git: " + why, "", ""}; }

Error git_failed_by_errno(const char* what) { return git_failed(std::string(what) + ": " + std::strerror(errno)); }

// An unnamed file with this text, at its beginning.
Stream scratch_file(std::string_view text) {
  Stream file(std::tmpfile());
  if (!file) return file;
  const bool written = std::fwrite(text.data(), 1, text.size(), file.get()) == text.size();
  if (!written || std::fflush(file.get()) != 0 || ::lseek(::fileno(file.get()), 0, SEEK_SET) != 0) file.reset();
  return file;
}

// The first line of what git wrote to standard error that is no warning, without "fatal: ".
std::string words_of(std::FILE* file) {
  std::array<char, kMostWords> text{};
  if (::lseek(::fileno(file), 0, SEEK_SET) != 0) return "";
  const ssize_t count = ::read(::fileno(file), text.data(), text.size());
  std::string_view words(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
  while (words.starts_with("warning: ") && words.find('\n') < words.size() - 1)
    words.remove_prefix(words.find('\n') + 1);
  words = words.substr(0, words.find('\n'));
  if (words.starts_with("fatal: ")) words.remove_prefix(7);
  return std::string(words);
}

class FileActions {
 public:
  FileActions() { posix_spawn_file_actions_init(&actions_); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;

  void set(int target, int file) { posix_spawn_file_actions_adddup2(&actions_, file, target); }
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

// A command that runs. It is killed once it is interrupted or its time is over.
class Command {
 public:
  Command(pid_t process, Descriptor output, const Interrupted& interrupted)
      : process_(process), output_(std::move(output)), interrupted_(interrupted) {}

  // Waits for output. Returns the number of bytes; 0: it has ended; -1: it was killed, or errno says what failed.
  ssize_t read(char* buffer, std::size_t size) {
    while (goes_on()) {
      pollfd output{output_.get(), POLLIN, 0};
      if (::poll(&output, 1, kTickMs) <= 0) continue;
      const ssize_t count = ::read(output_.get(), buffer, size);
      if (count >= 0 || errno != EINTR) return count;
    }
    return -1;
  }

  // Closes the output, which ends a command that goes on printing, and waits. Returns its exit code; -1: it was killed.
  int exit_code() {
    output_.close();
    for (int status = 0;;) {
      const pid_t ended = ::waitpid(process_, &status, WNOHANG);
      if (ended == process_) return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      if (ended < 0 && errno != EINTR) return -1;
      goes_on();
      ::poll(nullptr, 0, 1);
    }
  }

  const std::string& why_killed() const { return why_killed_; }  // empty: it was not

 private:
  bool goes_on() {
    if (!why_killed_.empty()) return false;
    if (interrupted_()) why_killed_ = "it was interrupted";
    if (std::chrono::steady_clock::now() > last_) why_killed_ = "it took longer than ten minutes";
    if (why_killed_.empty()) return true;
    ::kill(process_, SIGKILL);
    return false;
  }

  const pid_t process_;
  Descriptor output_;
  const Interrupted& interrupted_;
  const std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now() + kMostTime;
  std::string why_killed_;
};

ssize_t read_output(void* command, char* buffer, std::size_t size) {
  return static_cast<Command*>(command)->read(buffer, size);
}

}  // namespace

Result<Done> Git::run(const std::vector<std::string>& arguments, std::string_view input, const Read& read) const {
  const Stream in = scratch_file(input), err = scratch_file("");
  int ends[2];
  if (!in || !err || ::pipe2(ends, O_CLOEXEC) != 0) return git_failed_by_errno("cannot be run");
  Descriptor from(ends[0]), to(ends[1]);
  FileActions actions;
  actions.set(STDIN_FILENO, ::fileno(in.get()));
  actions.set(STDOUT_FILENO, to.get());
  actions.set(STDERR_FILENO, ::fileno(err.get()));
  std::vector<std::string> words{"git", "-C", folder_.string()};
  words.insert(words.end(), kOnlyRealRepositories.begin(), kOnlyRealRepositories.end());
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment_of_git();
  pid_t process = 0;
  errno = ::posix_spawnp(&process, "git", actions.get(), nullptr, arguments_of(words).data(),
                         arguments_of(variables).data());
  if (errno == ENOENT) return git_failed("it is not installed");
  if (errno != 0) return git_failed_by_errno("cannot be run");
  to.close();
  Command command(process, std::move(from), interrupted_);
  const Stream out(::fopencookie(&command, "rb", {read_output, nullptr, nullptr, nullptr}));
  const bool is_whole = out && read(out.get());
  const int code = command.exit_code();
  if (!command.why_killed().empty()) return git_failed(command.why_killed());
  if (code == 0 && is_whole) return Done{};
  const std::string said = words_of(err.get());
  return git_failed(said.empty() ? "'git " + arguments.front() + "' did not answer" : said);
}

Result<std::string> Git::output(const std::vector<std::string>& arguments) const {
  std::string text;
  const auto done = run(arguments, "", [&](std::FILE* out) {
    std::array<char, 1 << 16> piece{};
    for (std::size_t n = 0; (n = std::fread(piece.data(), 1, piece.size(), out)) > 0;) text.append(piece.data(), n);
    return std::ferror(out) == 0;
  });
  if (!done) return done.error();
  if (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace meshgauge::check
