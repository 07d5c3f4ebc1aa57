// The documents of a batch: JSON, and JUnit XML.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "server/store/batch_store.h"

namespace meshgauge::server {

// Returns the document of GET /v1/batches/{id} and of the 202. `failures`, `running`: the comparisons to list in it.
// `kept`: how long the batch is kept after its end.
std::string to_json(const store::Batch& batch, const std::vector<store::BatchRow>& failures,
                    const std::vector<store::BatchRow>& running, std::chrono::seconds kept);

std::string progress_json(const store::Batch& batch);  // the data of a `progress` event, on one line
std::string result_line(const store::BatchRow& row);   // a line of results.jsonl, newline included

// A finished batch as JUnit XML: one suite with a test per comparison. Valid by the schema of Ant's reports
// (windyroad's JUnit.xsd, the strictest) and by that of Jenkins, for any names.
//
// A comparison whose gate has failed or is undecided is a <failure> of that type. One without a result is an <error> of
// type failed, cancelled or gone.
//
//   junit_head(batch) + junit_case(row)... + junit_tail()
std::string junit_head(const store::Batch& batch);
std::string junit_case(const store::Batch& batch, const store::BatchRow& row);
std::string junit_tail();

}  // namespace meshgauge::server
