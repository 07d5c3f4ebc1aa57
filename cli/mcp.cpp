// `meshgauge mcp`: the tools for programs that write CAD, over standard input and output.
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "api/base/byte_budget.h"
#include "api/base/machine.h"
#include "api/base/roots.h"
#include "api/base/text.h"
#include "api/compare/mesh_file.h"
#include "cli/commands.h"
#include "cli/mcp/lines.h"
#include "cli/mcp/session.h"
#include "cli/mcp/tool.h"
#include "cli/mcp/writer.h"

namespace meshgauge::cli {
namespace {

constexpr std::chrono::milliseconds kPatience{500};
constexpr std::size_t kMostUnwrittenBytes = std::size_t{16} << 20;
constexpr std::uint64_t kFileShare = 4;  // of the memory: all files at once, which are held whole

// Ends the process without destructors: readers that are left behind use what exit() destroys.
[[noreturn]] void leave(int exit_code) { std::_Exit(exit_code); }

// Some programs hand over descriptors that do not block.
void let_block(int file) {
  const int flags = ::fcntl(file, F_GETFL);
  if (flags >= 0 && (flags & O_NONBLOCK) != 0) ::fcntl(file, F_SETFL, flags & ~O_NONBLOCK);
}

// When standard output is closed the client has gone.
[[noreturn]] void leave_without_output(int error) {
  if (error == EPIPE) leave(kExitResult);
  std::fprintf(stderr, "meshgauge: standard output cannot be written: %s\n", std::strerror(error));
  leave(kExitError);
}

mcp::Context context_of(api::Roots roots) {
  api::Confines confines{std::move(roots)};
  const std::uint64_t bytes = api::memory_bytes() / kFileShare;
  confines.max_file_bytes = std::min(confines.max_file_bytes, bytes);
  confines.files = std::make_shared<api::ByteBudget>(bytes);
  return {std::make_shared<const api::Confines>(std::move(confines)), api::processors()};
}

void say_what_runs(const api::Roots& roots) {
  std::fprintf(stderr, "meshgauge: MCP on standard input and output; files may be read below %s\n",
               api::listed(roots.folders()).c_str());
  if (isatty(STDIN_FILENO) != 0)
    std::fputs("meshgauge: a client starts this program and sends messages of JSON-RPC; Ctrl-D ends it\n", stderr);
}

int run(const std::vector<std::string>& folders) {
  const auto roots = api::Roots::open(folders.empty() ? std::vector<std::string>{"."} : folders);
  if (!roots) return fail({ErrorCode::invalid_request, "--root: " + roots.error().message, "", "--root"});
  std::signal(SIGPIPE, SIG_IGN);  // write() says so
  let_block(STDIN_FILENO);
  let_block(STDOUT_FILENO);
  say_what_runs(*roots);
  const mcp::Context context = context_of(*roots);
  mcp::Writer writer(STDOUT_FILENO, kMostUnwrittenBytes, leave_without_output);
  mcp::Session session(context, context.processors, [&writer](std::string line, mcp::Session::Line what) {
    if (what == mcp::Session::Line::answer) return writer.send(std::move(line));
    writer.offer(std::move(line));
  });
  mcp::Lines lines(STDIN_FILENO, mcp::kMostMessageBytes);
  std::string line;
  while (true) {
    switch (lines.next(line)) {
      case mcp::Lines::Got::line:
        session.receive(line);
        break;
      case mcp::Lines::Got::too_long:
        session.refuse_long(lines.id());
        break;
      case mcp::Lines::Got::end:
        session.end(kPatience);
        writer.end(kPatience);
        leave(kExitResult);
    }
  }
}

}  // namespace

void add_mcp(CLI::App& app, int& exit_code) {
  CLI::App& command = *app.add_subcommand(
      "mcp", "Judge meshes for programs that write CAD: a server of the Model Context Protocol, over standard input");
  const auto folders = std::make_shared<std::vector<std::string>>();
  command
      .add_option("--root", *folders,
                  "A folder below which files may be read, the current one by default; may be repeated")
      ->allow_extra_args(false);
  command.callback([folders, &exit_code] { exit_code = run(*folders); });
}

}  // namespace meshgauge::cli
