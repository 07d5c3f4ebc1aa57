// Replaces the mesh names 'a' and 'b' of a comparison's messages by the files of a gate.
#pragma once

#include "check/gate.h"
#include "engine/result.h"

namespace meshgauge::check {

// Returns the error with every 'a' replaced by the gate's candidate and every 'b' by its baseline.
Error with_files(Error error, const Gate& gate);

}  // namespace meshgauge::check
