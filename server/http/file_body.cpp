#include "server/http/file_body.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <string_view>

namespace meshgauge::server {
namespace {

constexpr std::chrono::milliseconds kShortestWriteTime{30'000};
constexpr std::chrono::milliseconds kFilePieceTime{10'000};
constexpr std::size_t kLeastBytesPerMs = 512;
constexpr std::size_t kFilePiece = std::size_t{1} << 20;

std::string head_of(const Response& response, bool close) {
  std::string head = "HTTP/1.1 " + std::to_string(response.status) + " OK\r\nContent-Type: " + response.content_type +
                     "\r\nContent-Length: " + std::to_string(response.file->bytes.size());
  for (const auto& [name, value] : response.headers) head += "\r\n" + name + ": " + value;
  return head + (close ? "\r\nConnection: close\r\n\r\n" : "\r\n\r\n");
}

}  // namespace

void send_file(Exchange& exchange, bool close) {
  const auto file = exchange.response.file->bytes;
  const auto deadline = Clock::now() + kShortestWriteTime + std::chrono::milliseconds(file.size() / kLeastBytesPerMs);
  const auto write = [&](std::string_view bytes) {
    const auto piece_deadline = std::min(deadline, Clock::now() + kFilePieceTime);
    if (exchange.connection.write(bytes, piece_deadline, Connection::Counted::no) != Io::ok) return false;
    exchange.bytes_out += bytes.size();
    return true;
  };
  bool sent = write(head_of(exchange.response, close));
  std::string_view rest(reinterpret_cast<const char*>(file.data()), file.size());
  if (exchange.head.method == "HEAD") rest = {};
  while (sent && !rest.empty()) {
    const std::size_t count = std::min(rest.size(), kFilePiece);
    sent = write(rest.substr(0, count));
    rest.remove_prefix(count);
  }
  exchange.delivered = sent;
}

}  // namespace meshgauge::server
