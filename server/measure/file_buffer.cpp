#include "server/measure/file_buffer.h"

#include <unistd.h>

#include <cerrno>
#include <span>

#include "api/descriptor.h"

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
  if (error_number_ == 0 && !meshgauge::write_all(file_, std::as_bytes(std::span(bytes, count)))) error_number_ = errno;
  return error_number_ == 0;
}

}  // namespace meshgauge::server
