// Messages of a comparison know its meshes as 'a' and 'b'; those of a gate name its files.
#pragma once

#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

// The error with 'a' and 'b' replaced by the gate's candidate and baseline, wherever they stand in the message.
Error with_files(Error error, const Gate& gate);

}  // namespace meshgauge::check
