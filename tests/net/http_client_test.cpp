#include "net/http_client.h"

#include <csignal>

#include <doctest/doctest.h>

using namespace meshgauge::net;

TEST_CASE("http client: a peer that closes while it is written to does not end the process") {
  REQUIRE((std::signal(SIGPIPE, SIG_DFL) != SIG_ERR));
  const HttpClient client(HttpSettings{});
  CHECK((std::signal(SIGPIPE, SIG_DFL) == SIG_IGN));
}
