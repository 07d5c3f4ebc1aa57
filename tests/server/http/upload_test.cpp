#include "server/http/upload.h"

#include <unistd.h>

#include <filesystem>
#include <string>

#include <doctest/doctest.h>

using namespace meshgauge;
using server::ByteBudget;
using server::Upload;

namespace {

const std::string kTemp = std::filesystem::temp_directory_path().string();

std::string text_of(const Upload& upload) {
  return {reinterpret_cast<const char*>(upload.bytes().data()), upload.bytes().size()};
}

}  // namespace

TEST_CASE("upload: the bytes come back, from memory or from a file") {
  for (const std::size_t pieces : {0U, 1U, 5U, 100U}) {
    ByteBudget budget(1 << 30);
    std::string expected;
    {
      Upload upload(budget, kTemp);
      for (std::size_t i = 0; i < pieces; ++i) {
        const std::string piece(60'000 + i, static_cast<char>('a' + i % 26));
        REQUIRE(!upload.append(piece));
        expected += piece;
      }
      REQUIRE(!upload.finish());
      CHECK(text_of(upload) == expected);
      CHECK(budget.used() == expected.size());
    }
    CHECK(budget.used() == 0);
  }
}

TEST_CASE("upload: all uploads share one budget") {
  ByteBudget budget(100);
  Upload first(budget, kTemp);
  Upload second(budget, kTemp);
  CHECK(!first.append(std::string(60, 'x')));
  CHECK(!second.append(std::string(40, 'x')));
  const auto refusal = second.append("x");
  REQUIRE(refusal.has_value());
  CHECK(refusal->kind == api::ProblemKind::overloaded);
  CHECK(budget.used() == 100);
}

TEST_CASE("upload: one client's uploads leave room for another's, and give it back") {
  ByteBudget budget(1000);
  {
    Upload greedy({budget, "greedy"}, kTemp), more({budget, "greedy"}, kTemp);
    const std::string piece(10, 'x');
    while (!greedy.append(piece)) continue;
    CHECK(budget.used() == 750);
    CHECK(more.append(piece)->kind == api::ProblemKind::overloaded);
    Upload modest({budget, "modest"}, kTemp);
    CHECK(!modest.append(std::string(150, 'x')));
    CHECK(budget.used() == 900);
  }
  CHECK(budget.used() == 0);
}

TEST_CASE("upload: a directory without write access is an error") {
  ByteBudget budget(1 << 30);
  Upload upload(budget, "/nonexistent");
  CHECK(!upload.append("small"));
  const auto refusal = upload.append(std::string(1 << 20, 'x'));
  REQUIRE(refusal.has_value());
  CHECK(refusal->kind == api::ProblemKind::storage_unavailable);
  CHECK(server::open_unnamed_file("/nonexistent") < 0);
}

TEST_CASE("upload: the file's descriptor can be read and not written") {
  ByteBudget budget(1 << 30);
  Upload small(budget, kTemp);
  REQUIRE(!small.append("small"));
  REQUIRE(!small.finish());
  CHECK(small.file() == -1);
  Upload large(budget, kTemp);
  REQUIRE(!large.append(std::string(1 << 20, 'x')));
  REQUIRE(!large.finish());
  std::string back(2 << 20, '?');
  CHECK(::pread(large.file(), back.data(), back.size(), 0) == 1 << 20);
  CHECK(back.substr(0, 1 << 20) == text_of(large));
  CHECK(::write(large.file(), "y", 1) < 0);
}
