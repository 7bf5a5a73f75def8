/* Rock-like meshes for tests and benchmarks of the codec: naive surface nets over a chiselled, noisy ball, made in the way the
 * baker makes its own, without needing a bake. */
#ifndef SCREE_TESTS_SYNTHETIC_ROCK_H
#define SCREE_TESTS_SYNTHETIC_ROCK_H

#include "rock_set.h"

/* Fills *out; positions, occlusion and indices are malloc'ed, see synthetic_rock_free. At 10 voxels a cell and coarsening 1 a rock
 * has about 1,280 triangles. seed: which rock. steps_per_voxel: of the pack's lattice. coarsening: voxels per grid cell, 1 = LOD 0.
 */
void synthetic_rock_make(uint64_t seed, uint32_t voxels_per_cell, uint32_t steps_per_voxel, uint32_t coarsening, lattice_mesh* out);
void synthetic_rock_free(lattice_mesh* mesh);

#endif
