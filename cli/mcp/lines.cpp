#include "cli/mcp/lines.h"

#include <unistd.h>

#include <cerrno>
#include <new>

namespace meshgauge::mcp {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{64} << 10;

}  // namespace

bool Lines::fill() {
  chunk_.resize(kChunkBytes);
  at_ = 0;
  ssize_t count = 0;
  do count = ::read(file_, chunk_.data(), chunk_.size());
  while (count < 0 && errno == EINTR);
  chunk_.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
  return count > 0;
}

bool Lines::keep(std::string& line, std::string_view piece) const try {
  if (line.size() + piece.size() > most_) return false;
  line += piece;
  return true;
} catch (const std::bad_alloc&) {
  return false;
}

Lines::Got Lines::next(std::string& line) {
  line = std::string();  // a long one gives its memory back
  bool is_long = false;
  while (at_ < chunk_.size() || fill()) {
    const std::size_t end = chunk_.find('\n', at_);
    const std::string_view piece = std::string_view(chunk_).substr(at_, end == std::string::npos ? end : end - at_);
    at_ += piece.size();
    if (!is_long && !keep(line, piece)) {
      is_long = true;
      scanner_ = IdScanner();
      scanner_.take(line);
      line = std::string();
    }
    if (is_long) scanner_.take(piece);
    if (end == std::string::npos) continue;
    ++at_;
    return is_long ? Got::too_long : Got::line;
  }
  if (is_long) return Got::too_long;
  return line.empty() ? Got::end : Got::line;
}

}  // namespace meshgauge::mcp
