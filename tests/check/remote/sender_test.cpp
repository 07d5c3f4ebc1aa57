#include "check/remote/sender.h"

#include <cmath>
#include <filesystem>

#include <doctest/doctest.h>

#include "folder.h"

using namespace meshgauge;
using namespace meshgauge::check;
using namespace meshgauge::check::service;

TEST_CASE("sender: the baseline's diagonal, and no waiting for it once cancelled") {
  const meshgauge::api::test::Folder folder;
  Gate gate;
  gate.baseline = folder.write("b.off", meshgauge::api::test::small_mesh(1));
  Client client(RemoteOptions{}, "http://localhost");
  Sender sender(client);
  Control cancelled_one;
  cancelled_one.cancel();
  const auto refused = sender.baseline_diagonal(gate, cancelled_one);
  REQUIRE_FALSE(refused.ok());
  CHECK(refused.error().code == ErrorCode::out_of_time);
  CHECK(refused.error().part == "b");
  Control control;
  const auto found = sender.baseline_diagonal(gate, control);
  REQUIRE(found.ok());
  CHECK(*found == std::sqrt(2.0));
  gate.baseline = folder / "missing.off";
  const auto missing = sender.baseline_diagonal(gate, control);
  REQUIRE_FALSE(missing.ok());
  CHECK(missing.error().message.find("missing.off") != std::string::npos);
}
