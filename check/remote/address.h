// Where the service is, and what can be said to it in a header.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::check::service {

// What every path is put behind: "https://host:8443/prefix", without a slash at its end. Refused: another scheme than
// http and https, a user or a password (which is not repeated in the message), a query, a fragment.
Result<std::string> base_of(const std::string& url);

// The address of a path there, as a link in somebody's report: what could end one is percent-encoded. Precondition:
// `base` is from base_of().
std::string link_to(const std::string& base, const std::string& path);

// Whether nobody but this machine can read what is sent there: https, or http to localhost or a loopback address.
// Precondition: from base_of().
bool is_private(const std::string& base);

// Whether a bearer key can stand in a header: visible ASCII alone, and not empty.
bool is_key(std::string_view key);

// "attachment; filename=..." of the file's own name, without its folder: what may not stand in a header is replaced.
std::string disposition(const std::filesystem::path& file);

// Foreign text in a message: on one line, without control characters, at most `most` bytes.
std::string one_line(std::string_view text, std::size_t most = 500);

}  // namespace meshgauge::check::service
