// Inserts jobs as rows.
#pragma once

#include <span>
#include <string>

#include "server/store/postgres/connection.h"

namespace meshgauge::server::store {

struct JobRow {
  Job job;
  std::string work;  // BatchItem::work
};

// Skips jobs whose id or idempotency key exists already; returns the number of inserted rows.
std::uint64_t insert_rows(PgConnection& connection, std::span<const JobRow> rows);

}  // namespace meshgauge::server::store
