// The tables, and how a database of an older version of the program becomes one of this version.
#pragma once

#include <span>

#include "engine/result.h"
#include "server/store/migrated.h"
#include "server/store/sqlite.h"

namespace meshgauge::server::store {

// Step n makes version n+1 of version n; a new database is version 0. Steps are only ever added.
std::span<const char* const> schema_steps();

// Brings the database to the version of the last step: each step is one transaction, so whatever happens it is of one
// version or the next. Refuses a database that is another program's, of a later version, or damaged.
Result<Migrated> migrate(Connection& connection, std::span<const char* const> steps);

}  // namespace meshgauge::server::store
