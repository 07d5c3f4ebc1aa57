// New jobs as rows of the table.
#pragma once

#include <span>
#include <string>

#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

struct JobRow {
  Job job;
  std::string work;  // BatchItem::work
};

// Leaves out rows whose id or idempotency key is there already; returns the number of the others.
std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows);

}  // namespace meshgauge::server::store
