#include "check/revision/git.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <memory>

#include "api/base/descriptor.h"

namespace meshgauge::check {
namespace {

constexpr std::size_t kMostWords = 400;  // of what git says of a failure

struct StreamClosed {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using Stream = std::unique_ptr<std::FILE, StreamClosed>;

// What would lead git to another repository than that of the folder, and what would have it ask or translate.
bool is_passed_on(std::string_view variable) {
  constexpr std::array<std::string_view, 6> kNames{"GIT_DIR",    "GIT_WORK_TREE",       "GIT_INDEX_FILE",
                                                   "GIT_PREFIX", "GIT_TERMINAL_PROMPT", "LC_ALL"};
  return std::ranges::find(kNames, variable.substr(0, variable.find('='))) == kNames.end();
}

std::vector<std::string> environment_of_git() {
  std::vector<std::string> variables{"GIT_TERMINAL_PROMPT=0", "LC_ALL=C"};
  for (char** variable = environ; variable && *variable; ++variable) {
    if (is_passed_on(*variable)) variables.emplace_back(*variable);
  }
  return variables;
}

std::vector<char*> arguments_of(std::vector<std::string>& texts) {
  std::vector<char*> all;
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

// The first line of what git wrote to standard error, without "fatal: ".
std::string words_of(std::FILE* file) {
  std::array<char, kMostWords> text{};
  if (::lseek(::fileno(file), 0, SEEK_SET) != 0) return "";
  const ssize_t count = ::read(::fileno(file), text.data(), text.size());
  std::string_view words(text.data(), count > 0 ? static_cast<std::size_t>(count) : 0);
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

// Returns git's exit code; -1: it was killed.
int exit_code_of(pid_t process) {
  int status = 0;
  while (::waitpid(process, &status, 0) < 0) {
    if (errno != EINTR) return -1;
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace

Result<Done> Git::run(const std::vector<std::string>& arguments, std::string_view input, const Read& read) const {
  const Stream in = scratch_file(input), err = scratch_file("");
  int ends[2];
  if (!in || !err || ::pipe2(ends, O_CLOEXEC) != 0) return git_failed_by_errno("cannot be run");
  Descriptor to(ends[1]);
  Stream out(::fdopen(ends[0], "rb"));
  if (!out) {
    ::close(ends[0]);
    return git_failed_by_errno("cannot be run");
  }
  FileActions actions;
  actions.set(STDIN_FILENO, ::fileno(in.get()));
  actions.set(STDOUT_FILENO, to.get());
  actions.set(STDERR_FILENO, ::fileno(err.get()));
  std::vector<std::string> command{"git", "-C", folder_.string()};
  command.insert(command.end(), arguments.begin(), arguments.end());
  std::vector<std::string> variables = environment_of_git();
  pid_t process = 0;
  errno = ::posix_spawnp(&process, "git", actions.get(), nullptr, arguments_of(command).data(),
                         arguments_of(variables).data());
  if (errno == ENOENT) return git_failed("it is not installed");
  if (errno != 0) return git_failed_by_errno("cannot be run");
  to.close();
  const bool is_whole = read(out.get());
  out.reset();  // ends a command that goes on printing
  const int code = exit_code_of(process);
  if (code == 0 && is_whole) return Done{};
  const std::string words = words_of(err.get());
  return git_failed(words.empty() ? "'git " + arguments.front() + "' did not answer" : words);
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
