// A file of settings: a line each, `name = value`, in the syntax of TOML. Texts stand in double quotes, '#' begins a
// comment; there are no sections.
#pragma once

#include <string>
#include <string_view>

#include "engine/result.h"
#include "server/settings.h"

namespace meshgauge::server {

// Sets what the text names and leaves the rest. An unknown name, one that stands there twice and a value of another
// type are refused, with the line in the message.
Result<Done> apply_settings(std::string_view text, Settings& settings);

Result<Done> load_settings(const std::string& file, Settings& settings);  // messages begin with the file

// Such a text, which sets each as in `asked`; a comment says what `in_force`, which is checked(asked), made of it.
// A password in `database` is left out.
std::string to_text(Settings asked, Settings in_force);

}  // namespace meshgauge::server
