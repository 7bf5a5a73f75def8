/* The vertices of a shard_surface: normals, UVs and how open each place is. */
#ifndef SCREE_SURFACE_VERTICES_H
#define SCREE_SURFACE_VERTICES_H

#include <scree/frost.h>

#include "shard_surface.h"

enum { SURFACE_SOLID = 0, SURFACE_CUT = 2 }; /* scree_frost_vertex.material */

typedef struct surface_desc {
  const scree_shards_view* shards;
  const uint8_t* inside; /* of each shard, not 0 = it is part */
  double origin[3];      /* positions are relative to it */
  bool joints;           /* between shards, on the solid's surface too: see shard_surface.h */
  bool ground;           /* everything below the solid's lowest place is dark */
  scree_jobs jobs;       /* all zero = none */
} surface_desc;

/* What scree_frost_surface is, and where it comes from. */
typedef struct surface_vertices {
  scree_frost_surface surface;
  shard_surface source; /* triangle t of the surface is that of source.triangles[t] */
  uint32_t* place;      /* of each vertex of the surface: the vertex of the shards */
  uint32_t place_capacity;
} surface_vertices;

/* Returns SCREE_OK or OUT_OF_MEMORY; on failure nothing is held. */
scree_result surface_vertices_create(const surface_desc* desc, const scree_allocator* allocator, surface_vertices* out);
void surface_vertices_destroy(surface_vertices* vertices, const scree_allocator* allocator); /* all zero is allowed */

#endif
