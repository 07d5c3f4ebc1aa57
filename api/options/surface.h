// The surfaces on which a request is written, each with its own words. One reader (api/options/request.h) serves all of
// them.
#pragma once

#include <string>
#include <string_view>

namespace meshgauge::api {

struct Surface {
  enum Bit : unsigned { http = 1, manifest = 2, flags = 4, python = 8 };

  Bit bit;
  std::string (*name)(std::string_view pointer);  // of the member at this JSON pointer, as messages call it
  std::string_view option;                        // "option", "key"
  std::string_view object, array, nothing;        // "an object", "an array", "null"
  std::string_view a, b;                          // "mesh a", "the candidate"
  std::string_view a_to_b, b_to_a;                // the directions
  // People write it by hand: a share is a text with '%', since a bare number could be read either way; and every
  // region needs a limit, so the gate needs one for the rest.
  bool by_hand = false;
};

extern const Surface kHttp;
extern const Surface kPython;

// Returns "areas.beyond[0]" or "regions[0].box.min[2]".
std::string dotted(std::string_view pointer);

}  // namespace meshgauge::api
