/* A mesh on the lattice to a Draco blob. The C side of draco_encode.cpp, the only file that sees the encoder. */
#ifndef SCREE_DRACO_ENCODE_H
#define SCREE_DRACO_ENCODE_H

#include "rock_set.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Encodes a mesh and fills *out, whose blob is then owned by the caller: scree_rt_release(allocator, blob, blob_size, 1).
 *
 * Positions decode to the same integers; occlusion is first rounded to the levels that a pack keeps (runtime/occlusion.h), and
 * the digest is of the mesh with these levels, so that it equals the digest of what decodes. A mesh without triangles gives an
 * empty level. Triangles that use a vertex twice are not allowed: Draco drops them.
 * Returns SCREE_OK, INVALID_ARGUMENT (such a triangle, or an index out of range) or OUT_OF_MEMORY. Lets no exception out.
 * Thread safety: any number of threads at once when the allocator allows it. */
scree_result draco_encode(const lattice_mesh* mesh, const scree_allocator* allocator, rock_lod* out);

/* The choices of the encoder, for measuring them; draco_encode uses draco_encode_defaults(). Only what the defaults make is
 * accepted by the decoder. */
typedef struct draco_encode_options {
  int speed;              /* 0 smallest .. 10 fastest */
  int connectivity;       /* -1 as the speed says, else MeshEdgebreakerConnectivityEncodingMethod */
  bool sequential;        /* no edgebreaker: triangles as indices */
  int occlusion_bits;     /* 0 (none) .. 8 */
  bool occlusion_apart;   /* an attribute of its own instead of the positions' fourth component */
  bool keep_normals;      /* also store the area-weighted normals, 8 bits octahedral */
  bool separate_surfaces; /* let every attribute have seams, which Draco does below speed 6 unless told otherwise */
} draco_encode_options;

draco_encode_options draco_encode_defaults(void);
scree_result draco_encode_with(const draco_encode_options* options, const lattice_mesh* mesh, const scree_allocator* allocator,
                               rock_lod* out);

#ifdef __cplusplus
}
#endif

#endif
