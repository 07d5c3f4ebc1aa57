#include "api/text_file.h"

#include <cerrno>
#include <cstring>
#include <fstream>

#include "api/refused.h"

namespace meshgauge::api {

Result<std::string> read_text_file(const std::string& file, std::size_t max_bytes) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return refused(std::string("cannot be read: ") + std::strerror(errno));
  // Reads one byte more than the limit to detect a larger file; a device without end then ends as well.
  std::string text(max_bytes + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) return refused("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > max_bytes) return refused("larger than " + std::to_string(max_bytes) + " bytes");
  return text;
}

}  // namespace meshgauge::api
