// Collects the service's settings. A flag overrides a variable, a variable the file, the file the default.
#pragma once

#include <functional>
#include <string_view>

#include "engine/result.h"
#include "server/settings/settings.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

// Declares --config and, for each setting that `wanted` accepts, a flag with its variable. The returned function
// gives the settings after parsing.
std::function<Result<server::Settings>()> add_settings(
    CLI::App& command,
    const std::function<bool(std::string_view name)>& wanted = [](std::string_view) { return true; });

}  // namespace meshgauge::cli
