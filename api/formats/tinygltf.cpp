// tinygltf, compiled here without what reads pictures. Debian has it as a shared library alone, which the static reader
// of uploads cannot link; and libdraco carries one of its own under the same names, of another layout, which a linker
// may take instead of any that comes later.
#include <nlohmann/json.hpp>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

// What a loader is made with before its user puts his own in their place: no picture is read or written.
namespace tinygltf {

// NOLINTBEGIN(readability-identifier-naming): its names
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
