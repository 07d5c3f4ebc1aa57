// Reads messages from a stream, one on a line.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "cli/mcp/message.h"

namespace meshgauge::mcp {

class Lines {
 public:
  // Borrows the descriptor. A line has at most `most` bytes.
  Lines(int file, std::size_t most) : file_(file), most_(most) {}

  enum class Got { line, too_long, end };

  // Blocks until there is a whole line, and puts it into `line`, without its end; the last one may lack that. too_long:
  // a longer one, or one that there is no memory for, was read to its end and not kept; id() is that of its message.
  // end: of the stream, or it cannot be read.
  Got next(std::string& line);
  std::string id() const { return scanner_.id(); }

 private:
  bool fill();
  bool keep(std::string& line, std::string_view piece) const;  // false: it does not fit

  const int file_;
  const std::size_t most_;
  std::string chunk_;   // what was read last
  std::size_t at_ = 0;  // of that, what comes next
  IdScanner scanner_;
};

}  // namespace meshgauge::mcp
