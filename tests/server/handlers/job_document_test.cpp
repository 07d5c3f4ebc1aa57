#include "server/handlers/job_document.h"

#include <optional>
#include <string>

#include <doctest/doctest.h>

#include "api/options/request.h"

using namespace meshgauge;
using namespace meshgauge::server;

TEST_CASE("job document: it has the gate of the options, whether they were parsed here or not") {
  store::NewJob row;
  row.key = {"owner", "job"};
  row.options = R"({"gate": {"max_distance": 0.25, "units": "mm"}})";
  LiveJob parsed(row, api::parse_options(row.options).value(), MeshSource{}, MeshSource{}, true);
  LiveJob unparsed(row, std::nullopt, MeshSource{}, MeshSource{}, true);
  CHECK(parsed.view().request != nullptr);
  CHECK(unparsed.view().request == nullptr);
  const std::string document = to_json(parsed.view());
  CHECK(document.find(R"("gate":{"max_distance":0.25,"units":"mm"})") != std::string::npos);
  CHECK(to_json(unparsed.view()) == document);
  JobView last;
  last.row.state = store::JobState::done;
  parsed.ended(last);
  CHECK(parsed.view().row.state == store::JobState::done);
  CHECK(parsed.view().request != nullptr);
}
