// The JSON Schema of a comparison's options, made from their table (api/options/table.h).
#pragma once

#include "api/options/surface.h"
#include "cli/mcp/message.h"

namespace meshgauge::mcp {

// The options of a tool, which stand in its argument `options`: those that Python has.
extern const api::Surface kToolOptions;

// Each option with what it says, its type and its range; of one that is a shape an example. Its reader
// (api::read_request) says what is wrong with a shape.
Json options_schema();

}  // namespace meshgauge::mcp
