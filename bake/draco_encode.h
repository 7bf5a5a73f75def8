/* A mesh on the lattice to a Draco blob. The C side of draco_encode.cpp, the only file that sees the encoder. */
#ifndef SCREE_DRACO_ENCODE_H
#define SCREE_DRACO_ENCODE_H

#include "rock_set.h"

#ifdef __cplusplus
extern "C" {
#endif

/* Encodes a mesh and fills *out, whose blob is then owned by the caller: release(allocator, blob, blob_size, 1).
 *
 * Positions decode to the same integers; occlusion is first rounded to the levels that a pack keeps (runtime/occlusion.h), and
 * the digest is of the mesh with these levels, so that it equals the digest of what decodes. A mesh without triangles gives an
 * empty level. Triangles that use a vertex twice are not allowed: Draco drops them.
 * Returns SCREE_OK, INVALID_ARGUMENT (such a triangle, or an index out of range) or OUT_OF_MEMORY. Lets no exception out.
 * Thread safety: any number of threads at once when the allocator allows it. */
scree_result draco_encode(const lattice_mesh* mesh, const scree_allocator* allocator, rock_lod* out);

/* The choices of the encoder, for measuring them; draco_encode uses draco_encode_defaults(). */
typedef struct draco_encode_options {
  int encoding_speed;  /* 0 smallest .. 10 fastest */
  int decoding_speed;  /* as above; Draco takes the larger of the two for most of its choices */
  bool sequential;     /* no edgebreaker: triangles as deltas of indices */
  int occlusion_bits;  /* 1..8 */
  bool keep_normals;   /* also store the area-weighted normals, 8 bits octahedral */
  bool single_surface; /* all attributes share the triangles of the positions: nothing is spent on seams there cannot be */
  int submethod;       /* -1 as the speed says, else MeshEdgebreakerConnectivityEncodingMethod */
  int position_scheme; /* -1 as the speed says, else PredictionSchemeMethod */
} draco_encode_options;

draco_encode_options draco_encode_defaults(void);
scree_result draco_encode_with(const draco_encode_options* options, const lattice_mesh* mesh, const scree_allocator* allocator,
                               rock_lod* out);

#ifdef __cplusplus
}
#endif

#endif
