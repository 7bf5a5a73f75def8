/* What stands for the encoder in a build without Draco. */
#include "draco_encode.h"

draco_encode_options draco_encode_defaults(void) {
  return (draco_encode_options){0};
}

scree_result draco_encode_with(const draco_encode_options* options, const lattice_mesh* mesh, const scree_allocator* allocator,
                               rock_lod* out) {
  (void)options;
  (void)mesh;
  (void)allocator;
  *out = (rock_lod){0};
  return SCREE_ERROR_UNSUPPORTED;
}

scree_result draco_encode(const lattice_mesh* mesh, const scree_allocator* allocator, rock_lod* out) {
  return draco_encode_with(NULL, mesh, allocator, out);
}
