#include "check/remote/connection.h"

#include <csignal>

#include <doctest/doctest.h>

using namespace meshgauge::check::service;

TEST_CASE("connection: a peer that closes while it is written to does not end the process") {
  REQUIRE((std::signal(SIGPIPE, SIG_DFL) != SIG_ERR));
  const Access access;
  const Connection connection(access);
  CHECK((std::signal(SIGPIPE, SIG_DFL) == SIG_IGN));
}
