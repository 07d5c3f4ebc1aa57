// Statements of the embedded database that several of its files use.
#pragma once

#include "server/store/sqlite.h"

namespace meshgauge::server::store {

// false: there is a job of that id or that idempotency key already.
bool insert_row(Connection& connection, const NewJob& job, const std::string& work);
void insert_ended_row(Connection& connection, const Job& job);  // nothing changes if the job is there already

// Moves the times of a mesh forward, never back.
void use_mesh(Connection& connection, const BlobKey& key, TimePoint last_used, TimePoint expires);

}  // namespace meshgauge::server::store
