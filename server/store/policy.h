// Decisions that both stores share: whose job is next, and what the sweeps remove. Pure functions over what a store
// reads.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "server/store/job_store.h"

namespace meshgauge::server::store {

inline constexpr std::int64_t kPortion = 500;  // rows that one transaction ends or removes: other writes wait for it

// The order of claim_some(), lowest first: earlier by one second is as good as smaller by kBytesOfOneSecond.
std::int64_t rank_of(const NewJob& job);

// Jobs of one client, or of one batch of a client, of which some are queued.
struct Group {
  std::string name;
  std::int64_t rank = 0;  // the lowest of those that are queued
  std::int64_t running = 0;
};
// The group that claim_some() takes from: of those with the fewest running jobs the one with the lowest rank. nullptr:
// there is no group, or none of `clients`.
const Group* next_group(std::span<const Group> groups, JobStore::Clients clients = JobStore::Clients::all);

struct Candidate {
  std::uint64_t cost = 0;
  bool suspected = false;
};
// How many of a group's first jobs one claim takes: as many as cost kBytesOfOneSecond together, at least one, and none
// beside a suspected one.
std::size_t fit_in_claim(std::span<const Candidate> first);

struct Kept {
  std::string owner;
  std::uint64_t jobs = 0;
};

// The number of jobs that each owner may keep when all keep `max_kept`: an equal share, and what others leave of
// theirs.
std::uint64_t share_of(std::vector<Kept> kept, std::uint64_t max_kept);

// What owners keep beyond their share, at most `most` jobs of all together.
std::vector<Kept> beyond_share(const std::vector<Kept>& kept, std::uint64_t max_kept, std::uint64_t most);

}  // namespace meshgauge::server::store
