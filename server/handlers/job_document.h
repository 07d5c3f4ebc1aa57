// A job as JSON: GET /v1/comparisons/{id}, and the body of a 202.
#pragma once

#include <optional>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "server/measure/live_job.h"

namespace meshgauge::server {

std::string to_json(const JobView& job);

// The interval so far; null for a job that has ended, whose result has it, or that has none yet.
nlohmann::ordered_json progress_of(const store::Job& row);

// The result of a job, with `view`, the path of its page. Precondition: the job has a result.
std::string result_json(const store::Job& row);

// The gate of the request, as in its result; null without a gate. For clients that have not sent the job.
nlohmann::ordered_json gate_of(const store::Job& row);

// The problem of a job that ended without a result; "null": it did not.
std::string problem_json(const store::Job& row);

// The current interval on one line: the data of a `progress` event. `now`: JobStore::time(), whose clock dates the job.
std::string progress_json(const JobView& job, store::TimePoint now);

// 2026-03-01T12:00:00.000Z (RFC 3339).
std::string to_text(store::TimePoint time);
nlohmann::ordered_json time_or_null(const std::optional<store::TimePoint>& time);  // to_text()

}  // namespace meshgauge::server
