// Compiles tinygltf without its image reader. Debian has it only as a shared library, which the static reader of
// uploads cannot link.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#include <tiny_gltf.h>

// The default image callback of a loader: no image is read.
namespace tinygltf {

// NOLINTBEGIN(readability-identifier-naming): tinygltf's names
bool LoadImageData(Image* /*image*/, int /*index*/, std::string* /*error*/, std::string* /*warning*/, int /*width*/,
                   int /*height*/, const unsigned char* /*bytes*/, int /*size*/, void* /*user*/) {
  return false;
}
// NOLINTEND(readability-identifier-naming)

}  // namespace tinygltf
