/* How tinygltf is set up in every C++ file that uses it: no pictures, no Draco of its own. */
#ifndef SUPPORT_FILE_GLTF_H
#define SUPPORT_FILE_GLTF_H

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_USE_CPP14
#include <tiny_gltf.h>

#include "support_file.h"

#endif
