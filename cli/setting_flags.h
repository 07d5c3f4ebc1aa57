// The settings of the service from flags, variables and a file. A flag wins over a variable, a variable over the file,
// and the file over the default.
#pragma once

#include <functional>
#include <memory>
#include <string_view>

#include "engine/result.h"
#include "server/settings.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

// Declares --config and a flag for each setting that `wanted` names, with its variable. What it returns gives the
// settings once the command line is read.
std::function<Result<server::Settings>()> add_settings(
    CLI::App& command,
    const std::function<bool(std::string_view name)>& wanted = [](std::string_view) { return true; });

}  // namespace meshgauge::cli
