// A buffer for a std::ostream that writes to a borrowed descriptor.
#pragma once

#include <array>
#include <cstddef>
#include <streambuf>

namespace meshgauge::server {

class FileBuffer final : public std::streambuf {
 public:
  explicit FileBuffer(int file) : file_(file) { setp(buffer_.data(), buffer_.data() + buffer_.size()); }

  // Writes the rest. false: a write failed; error_number() has its errno.
  bool finish() { return flush_buffer(); }
  int error_number() const { return error_number_; }

 private:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* bytes, std::streamsize count) override;
  int sync() override { return flush_buffer() ? 0 : -1; }
  bool flush_buffer();
  bool write_all(const char* bytes, std::size_t count);

  const int file_;
  int error_number_ = 0;
  std::array<char, std::size_t{64} << 10> buffer_;
};

}  // namespace meshgauge::server
