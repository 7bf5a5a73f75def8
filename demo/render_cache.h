/* Which meshes are on the GPU: every (asset, level of detail) is decoded when it is first wanted, and not before. */
#ifndef RENDER_CACHE_H
#define RENDER_CACHE_H

#include "render.h"
#include "render_meshes.h"

#define RENDER_SOURCES 64

/* States of a (asset, lod) that has no row in `meshes`. */
#define RENDER_MESH_ABSENT UINT32_MAX
#define RENDER_MESH_WANTED (UINT32_MAX - 1)
#define RENDER_MESH_BROKEN (UINT32_MAX - 2)

typedef struct render_cached_source {
  bool used;
  render_source source;
  render_asset* assets;
  uint32_t* rows; /* asset * lod_count + lod -> row in meshes, or a state */
  render_meshes meshes;
} render_cached_source;

typedef struct render_want {
  uint32_t source, asset, lod;
} render_want;

typedef struct render_cache {
  uint32_t instance_buffer;
  scree_jobs jobs;
  uint64_t bytes_most; /* of all sources; passing it forgets everything and starts over */
  render_cached_source sources[RENDER_SOURCES];
  render_want* wants;
  uint32_t want_count, want_capacity;
  uint32_t decoded; /* by the last call of render_cache_decode */
} render_cache;

void render_cache_create(render_cache* cache, uint32_t instance_buffer, const scree_jobs* jobs);
void render_cache_destroy(render_cache* cache);

uint32_t render_cache_add(render_cache* cache, const render_source* source);
void render_cache_remove(render_cache* cache, uint32_t source);

/* Forgets every mesh when they have grown past bytes_most. Called before a picture chooses its meshes, never within one. */
void render_cache_trim(render_cache* cache);

/* The row to draw for a level: the level itself, or the nearest coarser, then the nearest finer one that is there, or
 * RENDER_NOTHING. Notes that the level is wanted when it is absent. */
uint32_t render_cache_find(render_cache* cache, uint32_t source, uint32_t asset, uint32_t lod, uint32_t* found_lod);

/* Decodes what is wanted, at most `budget` meshes (0 = all), the rest stays absent and is asked for again. Returns how many are
 * still missing. */
uint32_t render_cache_decode(render_cache* cache, uint32_t budget);

uint32_t render_cache_mesh_count(const render_cache* cache);
uint64_t render_cache_bytes(const render_cache* cache);

#endif
