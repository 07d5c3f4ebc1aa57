// A job as its owner sees it: GET /v1/comparisons/{id}, and the body of a 202.
#pragma once

#include <string>

#include "api/problem.h"
#include "server/jobs/live_job.h"

namespace meshgauge::server {

std::string to_json(const JobView& job);

// The result of a job that has one, and where a browser sees it.
std::string result_json(const store::Job& row);

// Why a job ended without a result; "null" when it did not.
std::string problem_json(const store::Job& row);

// Of one that ended elsewhere: with what its document says of its stages.
JobView as_told(const store::Job& row);

// The interval as it stands, one line: the data of a `progress` event.
std::string progress_json(const JobView& job);

// Of one that its owner cancelled before there was an interval to give.
api::Problem cancelled_early();

std::string to_string(store::JobState state);

// 2026-03-01T12:00:00.000Z (RFC 3339).
std::string to_text(store::TimePoint time);

}  // namespace meshgauge::server
