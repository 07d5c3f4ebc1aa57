// The address of a service, and texts that may go into headers and links.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "engine/result.h"

namespace meshgauge::check::service {

// Returns the base of every URL: "https://host:8443/prefix", without a trailing slash. Refuses schemes other than
// http and https, a user or password (not repeated in the message), a query, a fragment.
Result<std::string> base_of(const std::string& url);

// Returns the URL of a path as a link for reports: characters that could end a link are percent-encoded.
// Precondition: `base` is from base_of().
std::string link_to(const std::string& base, const std::string& path);

// Whether what is sent there can be read by this machine and the service alone: https, or http to localhost or a
// loopback address. Precondition: `base` is from base_of().
bool is_private(const std::string& base);

// Whether `key` can be a bearer key: visible ASCII, not empty.
bool is_key(std::string_view key);

// Returns "attachment; filename=..." with the file's name, without its folder; characters that a header forbids are
// replaced.
std::string disposition(const std::filesystem::path& file);

// Returns foreign text for a message: one line, no control characters, at most `most` bytes.
std::string one_line(std::string_view text, std::size_t most = 500);

}  // namespace meshgauge::check::service
