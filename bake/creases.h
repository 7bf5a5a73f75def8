/* Where the surface of a solid is smooth: normals of the corners of its triangles. */
#ifndef SCREE_CREASES_H
#define SCREE_CREASES_H

#include <scree/shards.h>

/* Edges whose triangles' normals have a smaller cosine than this, 40 degrees, stay sharp. */
#define CREASE_COSINE 0.766

/* normals: 9 doubles a triangle, unit: of each corner, the mean by area over the triangles around its vertex that smooth edges
 * join. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result crease_normals(const scree_solid* solid, const scree_allocator* allocator, double* normals);

/* charts: of each triangle, the lowest triangle that smooth edges join it to. Returns SCREE_OK or OUT_OF_MEMORY. */
scree_result crease_charts(const scree_solid* solid, const scree_allocator* allocator, uint32_t* charts);

#endif
