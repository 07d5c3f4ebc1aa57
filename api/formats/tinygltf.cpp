// Compiles tinygltf without its image reader. Debian has it only as a shared library, which the static reader of
// uploads cannot link. libdraco contains a tinygltf of another layout under the same names, which a linker may take
// instead of a later library.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

// The default image callbacks of a loader: no image is read or written.
namespace tinygltf {

// NOLINTBEGIN(readability-identifier-naming): tinygltf's names
bool LoadImageData(Image* /*image*/, int /*index*/, std::string* /*error*/, std::string* /*warning*/, int /*width*/,
                   int /*height*/, const unsigned char* /*bytes*/, int /*size*/, void* /*user*/) {
  return false;
}

bool WriteImageData(const std::string* /*path*/, const std::string* /*name*/, const Image* /*image*/, bool /*embed*/,
                    std::string* /*uri*/, void* /*user*/) {
  return false;
}
// NOLINTEND(readability-identifier-naming)

}  // namespace tinygltf
