#include "server/http/outgoing.h"

#include <algorithm>

namespace meshgauge::server {
namespace {

constexpr std::size_t kFilePiece = std::size_t{1} << 20;

}  // namespace

Transport::Step Outgoing::write(Transport& transport, std::string_view bytes, std::size_t& sent) {
  while (sent < bytes.size()) {
    const Transport::Moved moved = transport.write(bytes.substr(sent));
    if (moved.step != Transport::Step::done) return moved.step;
    sent += moved.bytes;
    written_ += moved.bytes;
  }
  return Transport::Step::done;
}

Transport::Step Outgoing::write(Transport& transport) {
  if (const auto step = write(transport, text_, text_sent_); step != Transport::Step::done) return step;
  text_.clear();
  text_sent_ = 0;
  const std::string_view rest(reinterpret_cast<const char*>(file_.bytes.data()), file_.bytes.size());
  std::size_t sent = 0;
  const auto step = write(transport, rest.substr(0, std::min(rest.size(), kFilePiece)), sent);
  file_.bytes = file_.bytes.subspan(sent);
  if (file_.bytes.empty()) file_ = {};
  return step;
}

}  // namespace meshgauge::server
