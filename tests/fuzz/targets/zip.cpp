// Zip archives: the input is an archive, and the content of entries of one that is put together here, with sizes in
// their plain places or in Zip64 fields. Asserted: entries that are put together are read back, the same either way;
// whatever else is read comes within the limit, twice the same; a refusal names its part; a record that is put in
// plain terms is one of the archive's own, of the same length.
#include "api/formats/file/zip.h"

#include <string>

#include "tests/api/formats/zip_files.h"
#include "tests/fuzz/targets/checks.h"
#include "tests/fuzz/targets/target.h"

namespace meshgauge::fuzz {
namespace {

using api::ZipArchive;
using api::test::ZipEntry;

constexpr std::size_t kMostExpanded = std::size_t{1} << 20U;

std::span<const std::byte> bytes_of(std::string_view text) { return std::as_bytes(std::span<const char>(text)); }

// What is read of the entries, or why not.
std::string told(std::string_view archive) {
  api::ReadLimits limits;
  limits.max_expanded_bytes = kMostExpanded;
  const api::Source source{bytes_of(archive), "a", limits};
  auto opened = ZipArchive::open(source);
  if (!opened) {
    require_answer(opened.error());
    return opened.error().message;
  }
  std::string out;
  std::size_t expanded = 0;
  for (const char* name : {"a", "B", "_rels/.rels", "missing"}) {
    const auto ok = opened->read(name, [&](std::string_view piece) -> std::optional<Error> {
      expanded += piece.size();
      out += piece;
      return std::nullopt;
    });
    require(expanded <= kMostExpanded, "entries expand within the limit");
    if (!ok) require_answer(ok.error());
    if (!ok) require(ok.error().part == "a", "a refusal names its part", ok.error().message);
    out += ok ? "\n" : "\nrefused " + ok.error().message;
  }
  return out;
}

void check_records(std::string_view archive) {
  for (std::size_t at = archive.find("PK\x01\x02"); at != std::string_view::npos;
       at = archive.find("PK\x01\x02", at + 1)) {
    const auto record = api::plain_zip_record(bytes_of(archive), at);
    require(record.size() <= archive.size() - at, "a record lies in its archive");
    require(record.empty() || record.size() >= 46, "a record is whole");
    require(record.empty() || std::equal(record.begin(), record.begin() + 20,
                                         bytes_of(archive).begin() + static_cast<std::ptrdiff_t>(at)),
            "a record stays what it is but for its sizes");
  }
}

// minizip searches the end of an archive for the records that end a directory: those of a stored entry are taken for
// the archive's own.
bool holds_end_records(std::string_view content) {
  return content.find("PK\x06") != std::string_view::npos || content.find("PK\x05") != std::string_view::npos;
}

void check_made(const std::string& content, bool stored) {
  if (stored && holds_end_records(content)) return;
  std::vector<ZipEntry> entries{{"a", content}, {"b", content.substr(content.size() / 2)}};
  if (stored) entries[0].method = 0;
  const std::string plain = told(api::test::zip(entries));
  require(content.size() > kMostExpanded / 2 || plain.starts_with(content), "what was put in is read back");
  entries[0].in_zip64 = true;
  require(told(api::test::zip(entries)) == plain, "sizes of Zip64 are sizes", plain);
  entries[1].in_zip64 = true;
  require(told(api::test::zip64(entries, entries.size())) == plain, "a directory of Zip64 is a directory", plain);
}

}  // namespace
}  // namespace meshgauge::fuzz

FUZZ_TARGET(zip) {
  using namespace meshgauge::fuzz;
  const auto input = text_of(data, size);
  require(told(input) == told(input), "the same bytes give the same answer");
  check_records(input);
  check_made(std::string(input), size % 2 == 0);
  return 0;
}
