#include "api/formats/file/zip.h"

#include <doctest/doctest.h>

#include "tests/api/formats/files.h"
#include "tests/api/formats/zip_files.h"

namespace meshgauge::api::test {
namespace {

// Returns the content of an entry, or the message of the refusal.
std::string entry_of(const std::string& archive, const std::string& name, const ReadLimits& limits = {}) {
  const std::vector<char> exact(archive.begin(), archive.end());
  const Source source{std::as_bytes(std::span<const char>(exact)), "a", limits};
  auto opened = ZipArchive::open(source);
  if (!opened) return opened.error().message;
  std::string content;
  const auto ok = opened->read(name, [&](std::string_view piece) -> std::optional<Error> {
    content += piece;
    return std::nullopt;
  });
  return ok ? content : ok.error().message;
}

const std::string kText = "some text, some text, some text";

}  // namespace

TEST_CASE("zip: entries stored and deflated, by names in any case") {
  std::string large;
  while (large.size() < 200'000) large += std::to_string(large.size()) + " ";
  const std::string archive = zip({{"a/Stored.txt", kText, 0}, {"deflated.txt", large}, {"empty", ""}}, "a comment");
  CHECK(entry_of(archive, "a/Stored.txt") == kText);
  CHECK(entry_of(archive, "A/STORED.TXT") == kText);
  CHECK(entry_of(archive, "deflated.txt") == large);
  CHECK(entry_of(archive, "empty").empty());
  CHECK(entry_of(archive, "stored.txt") == "stored.txt of 'a': missing from the zip archive");
  CHECK(entry_of("self-extracting" + archive, "deflated.txt") == large);
  CHECK(contains(entry_of(zip({}), "x"), "'a'"));
}

TEST_CASE("zip: the records of Zip64") {
  CHECK(entry_of(zip64({{"a", kText}, {"b", "other"}}, 2), "a") == kText);
  CHECK(contains(entry_of(zip64({{"a", kText}}, std::uint64_t{1} << 60U), "a"), "damaged directory, after 1 entries"));
}

TEST_CASE("zip: entries whose sizes and places are in Zip64 fields") {
  const auto both = [](ZipEntry second) {
    second.in_zip64 = true;
    return std::vector<ZipEntry>{{"a", kText, 8, 0, 0, 0, true}, std::move(second), {"c", "plain"}};
  };
  for (const std::uint16_t method : {std::uint16_t{0}, std::uint16_t{8}}) {
    const auto entries = both({"b", "other", method});
    for (const std::string& archive : {zip(entries), zip64(entries, 3), "self-extracting" + zip(entries)}) {
      CHECK(entry_of(archive, "a") == kText);
      CHECK(entry_of(archive, "b") == "other");
      CHECK(entry_of(archive, "c") == "plain");
    }
  }
  CHECK(contains(entry_of(zip(both({"b", "other", 8, 0, 1})), "b"), "truncated: 6 bytes are announced, 5 were read"));
  CHECK(contains(entry_of(zip(both({"b", "other", 0, 0, 0, 1})), "b"), "damaged: its CRC does not match"));
  ZipEntry large{"b", "other"};
  large.size_lie_64 = std::uint64_t{1} << 32U;
  CHECK(entry_of(zip(both(large)), "a") == "b of 'a': an entry of 4 GiB or more, or a damaged Zip64 field");
}

TEST_CASE("zip: a stored entry that begins like a record of a directory is not one") {
  const std::string other = zip({{"b", kText, 8, 0, 0, 0, true}});
  const std::size_t begin = other.find("PK\x01\x02");
  const std::string record = other.substr(begin, other.find("PK\x05\x06") - begin);
  CHECK(entry_of(zip({{"a", record, 0}}), "a") == record);
}

TEST_CASE("zip: a cut or changed Zip64 field is noticed, or does not change an entry") {
  const std::string archive = zip({{"a", kText, 8, 0, 0, 0, true}, {"b", kText, 0, 0, 0, 0, true}});
  for (std::size_t at = 0; at < archive.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string changed = archive;
      changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
      for (const char* name : {"a", "b"}) {
        const std::string answer = entry_of(changed, name);
        CAPTURE(at);
        CHECK((answer == kText || contains(answer, "'a'")));
      }
    }
  }
}

TEST_CASE("zip: names that lead out of the archive have no effect") {
  const std::string archive = zip({{"../../etc/passwd", "inside"}, {"/etc/passwd", "inside"}});
  CHECK(entry_of(archive, "../../etc/passwd") == "inside");
  CHECK(entry_of(archive, "/etc/passwd") == "inside");
  CHECK(contains(entry_of(archive, "etc/passwd"), "missing"));
}

TEST_CASE("zip: backslashes are joined on request, if all names stay different") {
  const auto joined = [](const std::vector<ZipEntry>& entries) -> std::string {
    const std::string archive = zip(entries);
    const ReadLimits limits;
    const Source source{bytes_of(archive), "a", limits};
    auto opened = ZipArchive::open(source);
    REQUIRE(opened.ok());
    CHECK(!opened->has("a/b/c"));
    const auto renamed = opened->join_backslashes();
    if (!renamed) return renamed.error().message;
    CHECK(opened->has("a/b/c"));
    return std::to_string(*renamed);
  };
  CHECK(joined({{"A\\b\\C", "1"}, {"d/e", "2"}, {"f\\g", "3"}}) == "2");
  CHECK(joined({{"a\\b/c", "1"}, {"A/b\\c", "2"}}) ==
        "a\\b/c of 'a': occurs twice in the zip archive, with '/' and with '\\' between folders");
}

TEST_CASE("zip: encrypted, unsupported and damaged entries are refused by name") {
  CHECK(entry_of(zip({{"a", kText, 8, 1}}), "a") == "a of 'a': encrypted");
  CHECK(contains(entry_of(zip({{"a", kText, 12}}), "a"), "compressed by method 12; only deflate is supported"));
  CHECK(contains(entry_of(zip({{"a", kText, 8, 0, 0, 1}}), "a"), "damaged: its CRC does not match"));
  CHECK(contains(entry_of(zip({{"a", kText, 0, 0, 0, 1}}), "a"), "damaged: its CRC does not match"));
  CHECK(contains(entry_of(zip({{"a", kText, 8, 0, 5}}), "a"), "truncated: 36 bytes are announced, 31 were read"));
  CHECK(!contains(entry_of(zip({{"a", kText, 8, 0, 0xFFFFFFF0}}), "a"), "text"));  // 15 bytes announced: the CRC of 31
  CHECK(contains(entry_of(zip({{"a", "1"}, {"b", "2"}, {"A", "3"}}), "b"), "A of 'a': occurs twice"));
}

TEST_CASE("zip: an archive cut anywhere is refused") {
  const std::string archive = zip({{"a", kText}, {"b", kText, 0}});
  for (std::size_t length = 0; length < archive.size(); ++length) {
    CAPTURE(length);
    CHECK(contains(entry_of(archive.substr(0, length), "a"), "'a' is a zip archive without a directory"));
  }
}

TEST_CASE("zip: a changed byte is noticed, or does not change an entry") {
  const std::string archive = zip({{"a", kText}, {"b", kText, 0}});
  for (std::size_t at = 0; at < archive.size(); ++at) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      std::string changed = archive;
      changed[at] = static_cast<char>(changed[at] ^ (1 << bit));
      for (const char* name : {"a", "b"}) {
        const std::string answer = entry_of(changed, name);
        CAPTURE(at);
        CHECK((answer == kText || contains(answer, "'a'")));
      }
    }
  }
}

TEST_CASE("zip: all entries together expand to no more than the limit") {
  ReadLimits limits;
  limits.max_expanded_bytes = kText.size();
  CHECK(entry_of(zip({{"a", kText}}), "a", limits) == kText);
  --limits.max_expanded_bytes;
  CHECK(contains(entry_of(zip({{"a", kText}}), "a", limits), "'a' expands to more than 30 bytes"));
  const std::string bomb = zip({{"a", std::string(80'000'000, ' ')}});
  CHECK(contains(entry_of(bomb, "a"), "expands to more than 67108864 bytes"));
}

TEST_CASE("zip: the number of entries is limited") {
  std::vector<ZipEntry> many;
  for (int i = 0; i < 10'001; ++i) many.push_back({std::to_string(i), "", 0});
  CHECK(contains(entry_of(zip(many), "1"), "more than 10000 entries"));
  many.pop_back();
  CHECK(entry_of(zip(many), "1").empty());
}

}  // namespace meshgauge::api::test
