// What an owner has in the store: its meshes, comparisons and batches, newest first, in pages. In the same database as
// the jobs, with the same guarantees and errors (job_store.h).
//
// A page begins after the last row of the page before, not at a number: rows that come or go meanwhile are neither
// listed twice nor left out.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/store/job_store.h"
#include "server/store/mesh_index.h"

namespace meshgauge::server::store {

struct Page {
  struct Place {  // of a row: newest first, and of one moment the greater id first
    TimePoint created;
    std::string id;
  };
  std::string owner;
  std::optional<Place> after;  // nullopt: from the newest on
  std::size_t most;
};

struct ListedJob {
  JobKey key;
  JobState state = JobState::queued;
  TimePoint created{};
  std::optional<TimePoint> started, finished, expires;
  std::string mesh_a, mesh_b, hints, verdict, batch;  // as in Job
};

struct ListedBatch {
  JobKey key;
  std::string name;
  TimePoint created{};
  bool cancel_requested = false;
  std::uint64_t unended = 0;  // its own that are queued or running; work that it shares with another counts there
};

struct JobsOfOwner {
  std::array<std::uint64_t, 5> by_state{};  // JobState
  std::uint64_t bytes = 0;                  // of the files of those that are queued or running
};

class Listings {
 public:
  virtual ~Listings() = default;

  // Each returns at most page.most rows; fewer: there are no more.
  virtual Result<std::vector<MeshRow>> list_meshes(const Page& page) = 0;
  virtual Result<std::vector<ListedJob>> list_jobs(const Page& page) = 0;  // what record() was given may be missing
  virtual Result<std::vector<ListedBatch>> list_batches(const Page& page) = 0;
  virtual Result<JobsOfOwner> jobs_owned(const std::string& owner) = 0;
  virtual Result<std::uint64_t> batches_owned(const std::string& owner) = 0;  // their number
};

}  // namespace meshgauge::server::store
