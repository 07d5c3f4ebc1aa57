// The JSON documents of a batch.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "api/result_document.h"
#include "server/store/batch_store.h"

namespace meshgauge::server {

// Returns the document of GET /v1/batches/{id} and of the 202. `failures`: the comparisons to list in it. `kept`: how
// long the batch is kept after its end.
std::string to_json(const store::Batch& batch, const std::vector<store::BatchRow>& failures, std::chrono::seconds kept);

std::string progress_json(const store::Batch& batch);  // the data of a `progress` event, on one line
std::string result_line(const store::BatchRow& row);   // a line of results.jsonl, newline included

// Facts from a job's result and options, for reports.
std::optional<api::ResultFacts> facts_of(const store::Job& job);  // nullopt: it has no result
std::optional<double> limit_of(const store::Job& job);            // max_distance of its gate; nullopt: none
// The unit of all lengths of the result, such as "mm"; without a result that of the limit. Empty: not known.
std::string unit_of(const store::Job& job);

}  // namespace meshgauge::server
