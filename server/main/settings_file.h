// Reads and writes a settings file: one `name = value` per line, in the syntax of TOML without sections. Texts are in
// double quotes; '#' starts a comment.
#pragma once

#include <string>
#include <string_view>

#include "engine/result.h"
#include "server/settings/settings.h"

namespace meshgauge::server {

// Sets the settings that the text names and leaves the rest. An Error names the line of an unknown name, a name that
// occurs twice, or a value of the wrong type; settings of earlier lines are then set.
Result<Done> apply_settings(std::string_view text, Settings& settings);

Result<Done> load_settings(const std::string& file, Settings& settings);  // messages begin with the file's name

// Returns the text of a settings file with every setting of `asked`, and its help as a comment. Where `in_force`, which
// is checked(asked), differs, another comment shows its value. A password in `database` is left out.
std::string to_text(Settings asked, Settings in_force);

}  // namespace meshgauge::server
