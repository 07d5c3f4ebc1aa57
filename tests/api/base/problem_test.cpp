#include "api/base/problem.h"

#include <fstream>
#include <set>
#include <string>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

using namespace meshgauge;
using nlohmann::json;

TEST_CASE("problem: an error becomes a document with its place") {
  const Error error{ErrorCode::non_finite_vertex, "vertex 17 of 'a' is NaN", "a", "vertex 17"};
  const json document = json::parse(to_json(api::to_problem(error)));
  CHECK(document ==
        json{{"type", "/problems/non-finite-vertex"},
             {"title", "A coordinate is NaN or infinite"},
             {"status", 422},
             {"detail", "vertex 17 of 'a' is NaN"},
             {"errors", {{{"part", "a"}, {"where", "vertex 17"}, {"message", "vertex 17 of 'a' is NaN"}}}}});
}

TEST_CASE("problem: every code has its status") {
  const std::pair<ErrorCode, int> expected[] = {
      {ErrorCode::invalid_request, 422},      {ErrorCode::unsupported_format, 415},
      {ErrorCode::unreadable_mesh, 422},      {ErrorCode::empty_mesh, 422},
      {ErrorCode::non_finite_vertex, 422},    {ErrorCode::index_out_of_range, 422},
      {ErrorCode::coordinate_too_large, 422}, {ErrorCode::too_large, 413},
      {ErrorCode::out_of_time, 503},          {ErrorCode::internal, 500},
      {ErrorCode::unit_conflict, 422},        {ErrorCode::storage_full, 507},
      {ErrorCode::storage_unavailable, 503},  {ErrorCode::storage_damaged, 503}};
  for (const auto& [code, status] : expected) {
    const api::Problem problem = api::to_problem(Error{code, "x", "", ""});
    CHECK(problem.status() == status);
    CHECK(problem.errors.empty());
  }
}

TEST_CASE("problem: kinds and slugs are unique") {
  std::set<std::string_view> slugs;
  std::set<api::ProblemKind> kinds;
  for (const api::ProblemRow& row : api::problem_table()) {
    CHECK(slugs.insert(row.slug).second);
    CHECK(kinds.insert(row.kind).second);
    CHECK(row.status >= 400);
    CHECK(row.slug.find_first_not_of("abcdefghijklmnopqrstuvwxyz-") == std::string_view::npos);
    CHECK(row.help.ends_with('.'));
    for (const std::string_view text : {row.title, row.help})
      CHECK(text.find_first_of("<>&") == std::string_view::npos);  // it stands in HTML
  }
  CHECK(kinds.size() == static_cast<std::size_t>(api::ProblemKind::internal) + 1);
}

TEST_CASE("problem: openapi.yaml has the same table") {
  std::ifstream file(MESHGAUGE_SOURCE_DIR "/openapi.yaml");
  std::string text;  // as if no line were broken
  for (std::string line; std::getline(file, line);) {
    const std::size_t begin = line.find_first_not_of(' ');
    if (begin != std::string::npos) text += line.substr(begin) + ' ';
  }
  const auto count = [&](const std::string& what) {
    std::size_t found = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++found;
    return found;
  };
  for (const api::ProblemRow& row : api::problem_table()) {
    const std::string line = "- properties: {type: {const: '/problems/" + std::string(row.slug) +
                             "'}, title: {const: \"" + std::string(row.title) +
                             "\"}, status: {const: " + std::to_string(row.status) + "}}";
    INFO(line);
    CHECK(count(line) == 1);
  }
  CHECK(count("- properties: {type: {const: '/problems/") == api::problem_table().size());
}

TEST_CASE("problem: the kind is the end of its type, of those that version 0.1 stored as well") {
  CHECK(api::slug_of("/problems/too-large") == "too-large");
  CHECK(api::slug_of("urn:meshgauge:problem:too-large") == "too-large");
  for (const char* none : {"", "about:blank", "/problems/", "too-large", "https://x/problems/too-large"})
    CHECK(api::slug_of(none).empty());
}

TEST_CASE("problem: bytes that are not UTF-8 do not break the document") {
  const api::Problem problem{api::ProblemKind::malformed_request, "part '\xff\xfe'", {{"\x80", "", ""}}};
  CHECK(json::parse(to_json(problem))["detail"] == "part '\xef\xbf\xbd\xef\xbf\xbd'");
}
