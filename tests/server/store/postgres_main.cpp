// All tests in one run, over one server. Ends with 77, which ctest takes as skipped, where PostgreSQL is not installed.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>

#include <iostream>

#include "postgres_server.h"

int main(int argc, char** argv) {
  if (meshgauge::server::store::PostgresServer::programs().empty()) {
    std::cout << "skipped: PostgreSQL is not installed\n";
    return 77;
  }
  return doctest::Context(argc, argv).run();
}
