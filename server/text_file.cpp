#include "server/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

namespace meshgauge::server {

Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes) {
  const auto failed = [](std::string why) { return Error{ErrorCode::invalid_request, std::move(why), "", ""}; };
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return failed(std::strerror(errno));
  std::string text(max_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return failed("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > max_bytes) return failed("is larger than " + std::to_string(max_bytes) + " bytes");
  return text;
}

}  // namespace meshgauge::server
