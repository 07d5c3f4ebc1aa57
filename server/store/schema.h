// The tables of the embedded database, and their migration from older versions of the program.
#pragma once

#include <span>

#include "engine/result.h"
#include "server/store/migrated.h"
#include "server/store/sqlite.h"

namespace meshgauge::server::store {

// Step n migrates version n to version n+1; a new database is version 0. Steps are added, never changed.
std::span<const char* const> schema_steps();

// Migrates the database to the version of the last step. Each step is one transaction, so a crash leaves one version or
// the next. Error: the database is another program's, of a later version, or damaged.
Result<Migrated> migrate(Connection& connection, std::span<const char* const> steps);

}  // namespace meshgauge::server::store
