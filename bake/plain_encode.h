/* A mesh on the lattice to a plain mesh, the form of every coarsest level: runtime/plain_mesh.h. */
#ifndef SCREE_PLAIN_ENCODE_H
#define SCREE_PLAIN_ENCODE_H

#include "rock_set.h"

/* Fills *out, whose blob is then owned by the caller, as draco_encode does. Occlusion keeps all its bits.
 * Returns SCREE_OK, INVALID_ARGUMENT (no triangle, an index out of range), RANGE (more vertices than 16 bits can number) or
 * OUT_OF_MEMORY. */
scree_result plain_encode(const lattice_mesh* mesh, const scree_allocator* allocator, rock_lod* out);

#endif
