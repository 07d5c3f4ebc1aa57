// A finished batch as JUnit XML: one suite with a test per comparison. Valid by the schema of Ant's reports
// (windyroad's JUnit.xsd, the strictest) and by that of Jenkins, for any names.
//
// A comparison whose gate has failed or is undecided is a <failure> of that type. One without a result is an <error> of
// type failed, cancelled or gone.
//
//   junit_head(batch) + junit_case(row)... + junit_tail()
#pragma once

#include <string>

#include "server/store/batch_store.h"

namespace meshgauge::server {

std::string junit_head(const store::Batch& batch);
std::string junit_case(const store::Batch& batch, const store::BatchRow& row);
std::string junit_tail();

}  // namespace meshgauge::server
