// The versions of a database's schema before and after it was opened.
#pragma once

#include <cstdint>
#include <string>

namespace meshgauge::server::store {

struct Migrated {
  std::int64_t from = 0;  // 0: a new database
  std::int64_t to = 0;    // that of this program

  bool changed() const { return from != to; }
};

// A sentence for the log and for `meshgauge migrate`.
inline std::string to_string(const Migrated& migrated) {
  const std::string to = std::to_string(migrated.to);
  if (!migrated.changed()) return "the schema is of version " + to + " already";
  return "the schema was brought from version " + std::to_string(migrated.from) + " to " + to;
}

}  // namespace meshgauge::server::store
