#include "server/http/event_stream.h"

#include <chrono>
#include <cstdio>
#include <exception>

namespace meshgauge::server {
namespace {

constexpr std::chrono::seconds kPieceTime{30};
constexpr std::chrono::seconds kSilence{15};  // proxies close connections that are silent for longer

std::string head_of(const Response& response) {
  std::string head = "HTTP/1.1 " + std::to_string(response.status) + " OK\r\nContent-Type: " + response.content_type;
  for (const auto& [name, value] : response.headers) head += "\r\n" + name + ": " + value;
  return head + "\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n\r\n";
}

std::string chunk_of(std::string_view piece) {
  char size[20];
  std::snprintf(size, sizeof size, "%zx\r\n", piece.size());
  return size + std::string(piece) + "\r\n";
}

}  // namespace

void send_stream(Exchange& exchange) {
  const auto write = [&](const std::string& bytes) {
    exchange.bytes_out += bytes.size();
    return exchange.connection.write(bytes, Clock::now() + kPieceTime) == Io::ok;
  };
  if (!write(head_of(exchange.response))) return;
  auto last = Clock::now();
  for (bool more = true; more;) {
    std::string piece;
    try {
      more = exchange.response.stream(piece);
    } catch (const std::exception& error) {
      exchange.failure = error.what();
      return;
    }
    if (exchange.connection.peer_gone()) return;
    if (piece.empty() && Clock::now() - last > kSilence) piece = ": still here\n\n";
    if (piece.empty()) continue;
    if (!write(chunk_of(piece))) return;
    last = Clock::now();
  }
  exchange.delivered = write("0\r\n\r\n");
}

std::string event(std::string_view name, std::string_view data) {
  return "event: " + std::string(name) + "\ndata: " + std::string(data) + "\n\n";
}

}  // namespace meshgauge::server
