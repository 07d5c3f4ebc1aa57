// A batch as its owner sees it.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "api/result_document.h"
#include "server/store/batch_store.h"

namespace meshgauge::server {

// GET /v1/batches/{id}, and the body of a 202. `kept`: how long after its end.
std::string to_json(const store::Batch& batch, const std::vector<store::BatchRow>& failures, std::chrono::seconds kept);

// One line: the data of a `progress` event.
std::string progress_json(const store::Batch& batch);

// One line of the results, its end included.
std::string result_line(const store::BatchRow& row);

// What a job's document and options say, for reports.
std::optional<api::ResultFacts> facts_of(const store::Job& job);  // nullopt: it has no result
std::optional<double> limit_of(const store::Job& job);            // of its gate
// Of every length that was measured, "mm"; before there is a result, of the limit. Empty: not known.
std::string unit_of(const store::Job& job);

}  // namespace meshgauge::server
