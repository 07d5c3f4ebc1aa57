// The flags of compare and check that are options of a request, by the table of options (api/options/table.h).
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "api/options/request.h"
#include "engine/result.h"

namespace CLI {
class App;
}

namespace meshgauge::cli {

class OptionFlags {
 public:
  enum class Command { compare, check };

  // Declares the flags of the command. The object must live as long as `app`.
  void declare(CLI::App& app, Command command);

  // Whether the flag is given.
  bool has(std::string_view flag) const;
  // What was given to it. Precondition: has(flag).
  const std::string& text(std::string_view flag) const { return flags_.at(flag).text; }
  // The flags that are given.
  std::vector<std::string> given() const;
  // The flags of which a gate needs one, --max-distance first.
  static std::vector<std::string> limits();

  // Returns the request, or what is wrong with the flags: an Error for each, the first with the others.
  Result<api::Request> request() const;

 private:
  struct Given {
    std::string text;
    bool is_on = false;
  };

  Result<nlohmann::json> document() const;

  Command command_ = Command::compare;
  std::map<std::string_view, Given> flags_;
};

}  // namespace meshgauge::cli
