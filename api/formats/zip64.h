// Rewrites the directory of a Zip64 archive as that of a plain one. minizip 1.1 (Debian 12) finds the directory of a
// Zip64 archive but leaves the sizes of its entries at 0xFFFFFFFF; later versions also read the rewritten records.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace meshgauge::api {

// Returns the directory record that begins at byte `at`, to the end of its extra fields, with the sizes and the offset
// of its Zip64 field in their plain places and that field's id changed to an unused one. Empty: no record begins there,
// it has no Zip64 field in use, or the field is damaged or holds a number of 4 GiB or more.
std::vector<std::byte> plain_zip_record(std::span<const std::byte> archive, std::size_t at);

}  // namespace meshgauge::api
