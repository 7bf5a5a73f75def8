/* Scratch memory of queries: buffers that grow to what the largest question so far needed and stay so. */
#ifndef SCREE_SCRATCH_H
#define SCREE_SCRATCH_H

#include <scree/scene.h>

/* Who uses which buffer. Questions that ask other questions must not share one with them. */
typedef enum scratch_use {
  /* of the rocks of a scene (scene_query.c and what it calls) */
  SCRATCH_INSTANCES,
  SCRATCH_IDS,
  SCRATCH_CANDIDATES,
  SCRATCH_KEPT_STARTS,
  SCRATCH_KEPT,
  SCRATCH_KEPT_BALLS,
  SCRATCH_KEPT_PARTS,
  SCRATCH_NEAR,
  SCRATCH_CELLS,
  SCRATCH_ERODED,
  SCRATCH_FAR,
  SCRATCH_ROCKS, /* what scree_rt_scene_block and scree_rt_scene_far deliver */
  /* of spatial questions */
  SCRATCH_SPATIAL_0,
  SCRATCH_SPATIAL_1,
  SCRATCH_SPATIAL_2,
  SCRATCH_SPATIAL_3,
  SCRATCH_USES
} scratch_use;

typedef struct scratch_buffer {
  void* memory;
  size_t size; /* bytes */
} scratch_buffer;

struct scree_scratch {
  scree_allocator allocator;
  scratch_buffer buffers[SCRATCH_USES];
};

/* At least count * size bytes, aligned to 64; what the buffer held is lost when it has to grow. NULL when memory is short: then the
 * buffer is empty. */
void* scree_rt_scratch_reserve(scree_scratch* scratch, scratch_use use, size_t count, size_t size);

/* The same, but the first `kept` elements stay. NULL when memory is short: then the buffer is as before. */
void* scree_rt_scratch_extend(scree_scratch* scratch, scratch_use use, size_t kept, size_t count, size_t size);

/* How many elements of this size the buffer has room for. */
static inline size_t scratch_room(const scree_scratch* scratch, scratch_use use, size_t size) {
  return scratch->buffers[use].size / size;
}

#endif
