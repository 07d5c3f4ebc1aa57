#include "server/maps/file_buffer.h"

#include <unistd.h>

#include <cerrno>

namespace meshgauge::server {

FileBuffer::int_type FileBuffer::overflow(int_type c) {
  if (!flush_buffer()) return traits_type::eof();
  if (!traits_type::eq_int_type(c, traits_type::eof())) sputc(traits_type::to_char_type(c));
  return traits_type::not_eof(c);
}

std::streamsize FileBuffer::xsputn(const char* bytes, std::streamsize count) {
  if (count <= epptr() - pptr()) return std::streambuf::xsputn(bytes, count);
  return flush_buffer() && write_all(bytes, static_cast<std::size_t>(count)) ? count : 0;
}

bool FileBuffer::flush_buffer() {
  const auto waiting = static_cast<std::size_t>(pptr() - pbase());
  setp(buffer_.data(), buffer_.data() + buffer_.size());
  return write_all(buffer_.data(), waiting);
}

bool FileBuffer::write_all(const char* bytes, std::size_t count) {
  while (error_number_ == 0 && count > 0) {
    const ssize_t n = ::write(file_, bytes, count);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      error_number_ = errno;
      break;
    }
    bytes += n;
    count -= static_cast<std::size_t>(n);
  }
  return error_number_ == 0;
}

}  // namespace meshgauge::server
