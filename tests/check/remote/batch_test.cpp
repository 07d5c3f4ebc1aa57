#include "check/remote/batch.h"

#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "check/remote/client.h"

using namespace meshgauge::check::service;

namespace {

const std::string kBatchId(32, '0');

std::string line(int position, const std::string& state = "failed") {
  return R"({"position":)" + std::to_string(position) + R"(,"name":null,"comparison":")" + kBatchId + R"(","state":")" +
         state + R"(","verdict":null,"result":null,"problem":{"type":"/problems/empty-mesh"}})" + "\n";
}

struct Taken {
  explicit Taken(std::size_t comparisons)
      : results(comparisons, [this](BatchLine taken) { lines.push_back(std::move(taken)); }) {
    results.begin();
  }

  std::vector<BatchLine> lines;
  BatchResults results;
};

}  // namespace

TEST_CASE("batch results: lines may arrive in any pieces") {
  const std::string text = line(0) + line(2, "cancelled") + line(3);
  for (std::size_t size = 1; size < 60; size += 7) {
    Taken taken(4);
    for (std::size_t at = 0; at < text.size(); at += size) REQUIRE(taken.results.take(text.substr(at, size)));
    REQUIRE(taken.lines.size() == 3);
    CHECK(taken.lines[1].position == 2);
    CHECK(taken.lines[1].end->problem->slug == "empty-mesh");
  }
}

TEST_CASE("batch results: bytes after the last line end are ignored") {
  Taken taken(2);
  const std::string whole = line(1);
  CHECK(taken.results.take(line(0) + whole.substr(0, whole.size() - 1)));
  CHECK(taken.lines.size() == 1);
  taken.results.begin();
  CHECK(taken.results.take(line(0) + line(1)));
  CHECK(taken.lines.size() == 3);
}

TEST_CASE("batch results: a result that is gone") {
  Taken taken(1);
  CHECK(taken.results.take(R"({"position":0,"name":null,"comparison":null,"state":"gone","result":null})"
                           "\n"));
  REQUIRE(taken.lines.size() == 1);
  CHECK_FALSE(taken.lines[0].end);
}

TEST_CASE("batch results: malformed results end the transfer") {
  const std::string deep = std::string(100'000, '[') + std::string(100'000, ']') + "\n";
  for (const std::string& text :
       {std::string("\n"), std::string("null\n"), std::string("{}\n"), std::string("[]\n"), deep, line(-1), line(2),
        line(1) + line(1), line(1) + line(0), line(0, "running"), line(0, "done\\n"),
        std::string("{\"position\":1e99}\n"), std::string("{\"position\":0.5}\n"), std::string("\xff\xfe\n")}) {
    Taken taken(2);
    CHECK_FALSE(taken.results.take(text));
  }
}

TEST_CASE("batch results: the length of a line is limited") {
  Taken taken(2);
  const std::string piece(1 << 20, 'x');
  std::size_t pieces = 0;
  while (pieces < 100 && taken.results.take(piece)) ++pieces;
  CHECK(pieces == kMostReplyBytes >> 20);
}
