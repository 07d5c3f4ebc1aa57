// What is to be sent to one client: text, then perhaps a file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "server/http/transport.h"

namespace meshgauge::server {

// Bytes, and the object that keeps them alive.
struct FileBody {
  std::span<const std::byte> bytes;
  std::shared_ptr<const void> holder;
};

class Outgoing {
 public:
  void add(std::string text) { text_.empty() ? text_ = std::move(text) : text_ += text; }  // precondition: no file
  void add(FileBody file) { file_ = std::move(file); }

  // Writes as much as the socket takes, up to 1 MiB of a file. Does not block. done: that is written; empty() says
  // whether more is left.
  Transport::Step write(Transport& transport);

  bool empty() const { return text_.size() == text_sent_ && file_.bytes.empty(); }
  bool has_file() const { return !file_.bytes.empty(); }
  std::uint64_t written() const { return written_; }  // in all

 private:
  Transport::Step write(Transport& transport, std::string_view bytes, std::size_t& sent);

  std::string text_;
  std::size_t text_sent_ = 0;
  FileBody file_;
  std::uint64_t written_ = 0;
};

}  // namespace meshgauge::server
