#include "api/options/surface.h"

#include <algorithm>

#include "api/base/text.h"

namespace meshgauge::api {
namespace {

std::string as_it_is(std::string_view pointer) { return pointer.empty() ? "the document" : std::string(pointer); }

}  // namespace

std::string dotted(std::string_view pointer) {
  std::string name;
  while (!pointer.empty()) {
    pointer.remove_prefix(1);
    const std::string_view part = pointer.substr(0, pointer.find('/'));
    pointer.remove_prefix(part.size());
    if (!part.empty() && std::ranges::all_of(part, is_digit)) {
      name.append("[").append(part).append("]");
    } else {
      name.append(name.empty() ? "" : ".").append(part);
    }
  }
  return name;
}

const Surface kHttp{Surface::http, as_it_is, "option", "an object", "an array",
                    "null",        "mesh a", "mesh b", "a_to_b",    "b_to_a"};

const Surface kPython{Surface::python, dotted, "option", "a mapping", "a list", "None", "a", "b", "a_to_b", "b_to_a"};

}  // namespace meshgauge::api
