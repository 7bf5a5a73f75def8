#include "shard_clip.h"

#include <math.h>
#include <string.h>

scree_result clip_reserve_(const scree_allocator* allocator, void** memory, uint32_t* capacity, uint32_t count, size_t needed,
                           size_t size) {
  if (needed <= *capacity) return SCREE_OK;
  if (needed > UINT32_MAX) return SCREE_ERROR_OUT_OF_MEMORY;
  size_t more = needed + needed / 2 + 64;
  if (more > UINT32_MAX) more = UINT32_MAX;
  void* grown = scree_rt_allocate(allocator, more, size);
  if (grown == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  if (count > 0) memcpy(grown, *memory, count * size);
  scree_rt_release(allocator, *memory, *capacity, size);
  *memory = grown;
  *capacity = (uint32_t)more;
  return SCREE_OK;
}

static void work_free(clip_work* work) {
  const scree_allocator* allocator = work->allocator;
  voronoi_grid_free(&work->grid, allocator);
  scree_rt_release(allocator, work->vertices, work->vertex_capacity, sizeof *work->vertices);
  scree_rt_release(allocator, work->segments, work->segment_capacity, sizeof *work->segments);
  scree_rt_release(allocator, work->parts, work->part_capacity, sizeof *work->parts);
  scree_rt_release(allocator, work->lists, work->input->seed_count, sizeof *work->lists);
  while (work->page != NULL) {
    clip_near_page* page = work->page;
    work->page = page->before;
    scree_rt_release(allocator, page, 1, sizeof *page + page->capacity * sizeof *page->near);
  }
  scree_rt_release(allocator, work->boxes, work->input->seed_count, sizeof *work->boxes);
}

static scree_result work_create(const shard_input* input, clip_work* work) {
  const clip_box nothing = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
  work->solid = nothing;
  for (size_t k = 0; k < 3 * (size_t)input->triangle_count; ++k) {
    const double* at = &input->positions[3 * (size_t)input->indices[k]];
    for (int axis = 0; axis < 3; ++axis) {
      if (at[axis] < work->solid.min[axis]) work->solid.min[axis] = at[axis];
      if (at[axis] > work->solid.max[axis]) work->solid.max[axis] = at[axis];
    }
  }
  const scree_result result = voronoi_grid_create(input->seeds, input->seed_count, work->allocator, &work->grid);
  if (result != SCREE_OK) return result;
  for (int axis = 0; axis < 3; ++axis)
    work->spacing = work->grid.step[axis] > work->spacing ? work->grid.step[axis] : work->spacing;
  work->lists = scree_rt_allocate_zeroed(work->allocator, input->seed_count, sizeof *work->lists);
  work->boxes = scree_rt_allocate(work->allocator, input->seed_count, sizeof *work->boxes);
  if (work->lists == NULL || work->boxes == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t seed = 0; seed < input->seed_count; ++seed) work->boxes[seed] = nothing;
  return SCREE_OK;
}

/* Room for what a mesh finer than its cells makes, about: what grows is copied, and touches memory twice. Before all else, so that
 * what follows is given back in one part. */
static scree_result reserve_pieces(const shard_input* input, shard_pieces* out) {
  const scree_allocator* allocator = &input->allocator;
  const size_t vertices = input->vertex_count, triangles = input->triangle_count, seeds = input->seed_count;
  scree_result result = clip_reserve_(allocator, (void**)&out->vertices, &out->vertex_capacity, 0, 4 * vertices / 3 + 5 * seeds,
                                      3 * sizeof *out->vertices);
  if (result == SCREE_OK) result = clip_reserve(allocator, &out->corners, &out->corner_capacity, 0, 4 * triangles + 28 * seeds);
  if (result == SCREE_OK) result = clip_reserve(allocator, &out->pieces, &out->piece_capacity, 0, triangles + 6 * seeds);
  return result;
}

scree_result shard_clip_cut(const shard_input* input, shard_pieces* out) {
  clip_work work = {.input = input, .allocator = &input->allocator};
  *out = (shard_pieces){0};
  scree_result result = reserve_pieces(input, out);
  if (result == SCREE_OK) result = work_create(input, &work);
  if (result == SCREE_OK) result = clip_surface(&work, out);
  if (result == SCREE_OK) result = clip_faces(&work, out);
  work_free(&work);
  if (result != SCREE_OK) shard_pieces_free(out, &input->allocator);
  return result;
}
