#include "check/remote/batch_results.h"

#include "check/remote/client.h"

namespace meshgauge::check::service {

void BatchResults::begin() {
  line_.clear();
  next_ = 0;
}

bool BatchResults::take(std::string_view piece) {
  for (std::size_t end = piece.find('\n'); end != std::string_view::npos; end = piece.find('\n')) {
    if (end > kMostReplyBytes - line_.size()) return false;
    line_.append(piece.substr(0, end));
    if (!take_line(line_)) return false;
    line_.clear();
    piece.remove_prefix(end + 1);
  }
  if (piece.size() > kMostReplyBytes - line_.size()) return false;
  line_.append(piece);
  return true;
}

bool BatchResults::take_line(std::string_view text) {
  auto line = batch_line_from(text);
  if (!line || line->position < next_ || line->position >= comparisons_) return false;
  next_ = line->position + 1;
  tell_(std::move(*line));
  return true;
}

}  // namespace meshgauge::check::service
