/* How tinygltf is set up in every C++ file that uses it: no pictures, no Draco of its own. */
#ifndef SUPPORT_FILE_GLTF_H
#define SUPPORT_FILE_GLTF_H

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_USE_CPP14
#include <tiny_gltf.h>

#include <stdexcept>

#include "support_file.h"

/* A fault of a file, to be told in one line that lacks only the file's name. */
struct gltf_fault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/* Loads .glb or .gltf from memory; `file` tells where other files are looked for. Meshes with KHR_draco_mesh_compression keep their
 * bytes, and what was their `indices` stands in the extension. Throws gltf_fault. */
void gltf_load(const char* bytes, size_t size, const char* file, tinygltf::Model& model);

#endif
