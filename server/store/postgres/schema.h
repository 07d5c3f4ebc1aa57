// The tables of the PostgreSQL database, and their migration from older versions of the program.
#pragma once

#include <span>

#include "engine/result.h"
#include "server/store/migrated.h"
#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

// Step n migrates version n to version n+1; a new database is version 0. Steps are added, never changed. Each must keep
// what processes of the version before read and write: they run on until they are replaced. The fifth step alone does
// not: processes of 0.1.0 fail after it, and lose nothing that they have acknowledged.
std::span<const char* const> pg_schema_steps();

// Migrates the database to the version of the last step, in one transaction. When many processes start at once, one
// does it and the others wait. Blocks until no other session uses the tables that change; sessions that come meanwhile
// go first. Error: another program's tables have the same names, a later version wrote the database, or the role lacks
// rights (the message names them). Throws PgFailure.
Result<Migrated> pg_migrate(PgConnection& connection, std::span<const char* const> steps);

}  // namespace meshgauge::server::store
