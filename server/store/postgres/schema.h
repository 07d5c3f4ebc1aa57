// The tables, and how a database of an older version of the program becomes one of this version.
#pragma once

#include <span>
#include <string>

#include "engine/result.h"
#include "server/store/migrated.h"
#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

// Step n makes version n+1 of version n; a new database is version 0. Steps are only ever added. They must leave what
// processes of the version before read and write, which go on until they are replaced. The fifth step alone does not:
// processes of 0.1.0 fail after it, and lose nothing that they have promised.
std::span<const char* const> pg_schema_steps();

// Brings the database to the version of the last step, all in one transaction; of many processes that begin at once
// one does it and the others wait. Waits until nobody else uses the tables that change, and lets others pass
// meanwhile. Refuses a database that has tables of the same names that are
// another program's, or that a later version wrote, and says what a role lacks that may not do it. Throws
// PgFailure.
Result<Migrated> pg_migrate(PgConnection& connection, std::span<const char* const> steps);

}  // namespace meshgauge::server::store
