#include <string.h>

#include "convex_walls.h"
#include "shard_pieces.h"
#include "vectors.h"
#include "voronoi_cell.h"

/* Cells of one job, and jobs before their cells are joined: what is held at once stays small. */
enum { BLOCK_CELLS = 64, MOST_BLOCKS = 64 };

/* Keys of a solid's own corners: KEY_SOLID and the vertex. */
#define KEY_SOLID UINT32_MAX

typedef struct cut_corner {
  double position[3];
  uint32_t key[4];
} cut_corner;

typedef struct cut_face {
  uint32_t neighbour, count;
} cut_face;

/* What one job made of its cells. */
typedef struct cut_block {
  cut_corner* corners;
  cut_face* faces;
  uint32_t* indices; /* of faces, from the first corner of their cell */
  uint32_t corner_count, face_count, index_count;
  uint32_t corner_capacity, face_capacity, index_capacity;
  uint32_t cell_corners[BLOCK_CELLS], cell_faces[BLOCK_CELLS];
  scree_result result;
} cut_block;

typedef struct cutting {
  const shard_input* input;
  voronoi_grid grid;
  convex_walls walls;
  voronoi_bounds bounds;
  voronoi_cell* cells; /* of each worker */
  cut_block* blocks;
  uint32_t worker_count, block_count, first_seed;
  /* Joining. */
  uint32_t (*keys)[4];  /* of each vertex of the pieces: vertex_capacity */
  uint32_t* seed_first; /* vertices whose lowest seed is s are seed_first[s] .. seed_end[s] - 1 */
  uint32_t* seed_end;
  uint32_t* solid_vertices; /* of each of the solid's: in the pieces */
  uint32_t* ids;            /* of the corners of one cell */
  uint32_t id_capacity;
  uint64_t awaited, met; /* how often other cells must name a vertex, and have */
} cutting;

static bool grow(const scree_allocator* allocator, void* array, uint32_t* capacity, size_t used, size_t count, size_t size) {
  if (count <= *capacity) return true;
  const size_t more = 2 * count > 256 ? 2 * count : 256;
  if (more >= UINT32_MAX) return false;
  void *old, *memory = scree_rt_allocate(allocator, more, size);
  if (memory == NULL) return false;
  memcpy(&old, array, sizeof old);
  if (used > 0) memcpy(memory, old, used * size);
  scree_rt_release(allocator, old, *capacity, size);
  memcpy(array, &memory, sizeof memory);
  *capacity = (uint32_t)more;
  return true;
}

/* --- cells, in any order ---------------------------------------------------------------------------------------------------- */

static bool keep_cell(const cutting* c, const voronoi_cell* cell, cut_block* block) {
  const scree_allocator* allocator = &c->input->allocator;
  if (!grow(allocator, &block->corners, &block->corner_capacity, block->corner_count,
            block->corner_count + (size_t)cell->corner_count, sizeof *block->corners) ||
      !grow(allocator, &block->faces, &block->face_capacity, block->face_count, block->face_count + (size_t)cell->face_count,
            sizeof *block->faces) ||
      !grow(allocator, &block->indices, &block->index_capacity, block->index_count, block->index_count + (size_t)cell->index_count,
            sizeof *block->indices))
    return false;
  for (uint32_t i = 0; i < cell->corner_count; ++i) {
    cut_corner* corner = block->corners + block->corner_count++;
    voronoi_cell_key(cell, i, corner->key);
    for (int axis = 0; axis < 3; ++axis) corner->position[axis] = cell->origin[axis] + cell->positions[i][axis];
    if (corner->key[1] < VORONOI_WALL + VORONOI_BOX) continue;
    const uint32_t first = VORONOI_WALL + VORONOI_BOX;
    const uint32_t vertex = convex_walls_corner(&c->walls, corner->key[1] - first, corner->key[2] - first, corner->key[3] - first);
    if (vertex == UINT32_MAX) continue;
    corner->key[0] = KEY_SOLID;
    corner->key[1] = vertex;
    memcpy(corner->position, c->input->positions + 3 * (size_t)vertex, sizeof corner->position);
  }
  for (uint32_t i = 0; i < cell->face_count; ++i)
    block->faces[block->face_count++] = (cut_face){cell->faces[i].neighbour, cell->faces[i].count};
  if (cell->index_count > 0) memcpy(block->indices + block->index_count, cell->indices, cell->index_count * sizeof *cell->indices);
  block->index_count += cell->index_count;
  return true;
}

static void cut_cells(void* context, uint32_t index, uint32_t worker) {
  cutting* c = context;
  cut_block* block = c->blocks + index;
  voronoi_cell* cell = c->cells + worker;
  block->corner_count = block->face_count = block->index_count = 0;
  block->result = SCREE_OK;
  for (uint32_t i = 0; i < BLOCK_CELLS; ++i) {
    const uint64_t seed = c->first_seed + (uint64_t)index * BLOCK_CELLS + i;
    block->cell_corners[i] = block->cell_faces[i] = 0;
    if (seed >= c->input->seed_count) continue;
    block->result = voronoi_cell_make(cell, &c->grid, (uint32_t)seed, &c->bounds, &c->input->allocator);
    if (block->result == SCREE_OK && !keep_cell(c, cell, block)) block->result = SCREE_ERROR_OUT_OF_MEMORY;
    if (block->result != SCREE_OK) return;
    block->cell_corners[i] = cell->corner_count;
    block->cell_faces[i] = cell->face_count;
  }
}

/* --- joining, in the order of seeds ----------------------------------------------------------------------------------------- */

/* Vertices and their keys are as many. */
static bool need_vertices(cutting* c, shard_pieces* out, size_t count) {
  const scree_allocator* allocator = &c->input->allocator;
  uint32_t key_capacity = out->vertex_capacity;
  if (count <= out->vertex_capacity) return true;
  if (!grow(allocator, &c->keys, &key_capacity, out->vertex_count, count, sizeof *c->keys)) return false;
  if (!grow(allocator, &out->vertices, &out->vertex_capacity, out->vertex_count, count, 3 * sizeof *out->vertices)) {
    /* Both stay of one length: the keys are of no more use. */
    scree_rt_release(allocator, c->keys, key_capacity, sizeof *c->keys);
    c->keys = NULL;
    return false;
  }
  return true;
}

static bool add_vertex(cutting* c, shard_pieces* out, const cut_corner* corner, uint32_t* id) {
  if (!need_vertices(c, out, out->vertex_count + (size_t)1)) return false;
  *id = out->vertex_count++;
  memcpy(out->vertices + 3 * (size_t)*id, corner->position, sizeof corner->position);
  memcpy(c->keys[*id], corner->key, sizeof corner->key);
  return true;
}

/* The vertex of a corner: made by the cell of its lowest seed, which comes first, found by the others. */
static scree_result vertex_of(cutting* c, shard_pieces* out, uint32_t seed, const cut_corner* corner, uint32_t* id) {
  if (corner->key[0] == KEY_SOLID) {
    uint32_t* known = c->solid_vertices + corner->key[1];
    if (*known == UINT32_MAX && !add_vertex(c, out, corner, known)) return SCREE_ERROR_OUT_OF_MEMORY;
    *id = *known;
    return SCREE_OK;
  }
  if (corner->key[0] == seed) {
    for (uint32_t k = 1; k < 4; ++k) c->awaited += corner->key[k] < VORONOI_WALL;
    return add_vertex(c, out, corner, id) ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t i = c->seed_first[corner->key[0]]; i < c->seed_end[corner->key[0]]; ++i)
    if (memcmp(c->keys[i], corner->key, sizeof corner->key) == 0) {
      ++c->met;
      *id = i;
      return SCREE_OK;
    }
  return SCREE_ERROR_UNSUPPORTED; /* the two cells do not see the same corners */
}

static scree_result add_piece(cutting* c, shard_pieces* out, uint32_t seed, uint32_t neighbour, const uint32_t* indices,
                              uint32_t count) {
  const scree_allocator* allocator = &c->input->allocator;
  if (!grow(allocator, &out->corners, &out->corner_capacity, out->corner_count, out->corner_count + (size_t)count,
            sizeof *out->corners) ||
      !grow(allocator, &out->pieces, &out->piece_capacity, out->piece_count, out->piece_count + (size_t)1, sizeof *out->pieces))
    return SCREE_ERROR_OUT_OF_MEMORY;
  shard_piece piece = {{seed, neighbour}, UINT32_MAX, out->corner_count, 0};
  if (neighbour >= VORONOI_WALL) {
    piece.cells[1] = PIECE_OUTSIDE;
    piece.triangle = c->walls.triangles[neighbour - VORONOI_WALL - VORONOI_BOX];
  }
  /* Corners that were told apart only to be seen alike are one again. */
  uint32_t* corners = out->corners + piece.first_corner;
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t id = c->ids[indices[i]];
    if (piece.corner_count == 0 || corners[piece.corner_count - 1] != id) corners[piece.corner_count++] = id;
  }
  while (piece.corner_count > 1 && corners[piece.corner_count - 1] == corners[0]) --piece.corner_count;
  if (piece.corner_count < 3) return SCREE_OK;
  out->corner_count += piece.corner_count;
  out->pieces[out->piece_count++] = piece;
  return SCREE_OK;
}

static scree_result join_cell(cutting* c, shard_pieces* out, uint32_t seed, const cut_corner* corners, uint32_t corner_count,
                              const cut_face* faces, uint32_t face_count, const uint32_t* indices) {
  if (!grow(&c->input->allocator, &c->ids, &c->id_capacity, 0, corner_count, sizeof *c->ids)) return SCREE_ERROR_OUT_OF_MEMORY;
  c->seed_first[seed] = out->vertex_count;
  for (uint32_t i = 0; i < corner_count; ++i) {
    const scree_result result = vertex_of(c, out, seed, corners + i, c->ids + i);
    if (result != SCREE_OK) return result;
  }
  c->seed_end[seed] = out->vertex_count;
  for (uint32_t k = 0; k < face_count; ++k) {
    const uint32_t neighbour = faces[k].neighbour;
    /* The box lies outside all walls: what reaches it is not closed. */
    if (neighbour >= VORONOI_WALL && neighbour < VORONOI_WALL + VORONOI_BOX) return SCREE_ERROR_UNSUPPORTED;
    if (neighbour > seed) {
      const scree_result result = add_piece(c, out, seed, neighbour, indices, faces[k].count);
      if (result != SCREE_OK) return result;
    }
    indices += faces[k].count;
  }
  return SCREE_OK;
}

static scree_result join_block(cutting* c, shard_pieces* out, uint32_t index) {
  const cut_block* block = c->blocks + index;
  const cut_corner* corners = block->corners;
  const cut_face* faces = block->faces;
  const uint32_t* indices = block->indices;
  if (block->result != SCREE_OK) return block->result;
  for (uint32_t i = 0; i < BLOCK_CELLS; ++i) {
    if (block->cell_corners[i] == 0) continue;
    const uint32_t seed = c->first_seed + index * BLOCK_CELLS + i, face_count = block->cell_faces[i];
    const scree_result result = join_cell(c, out, seed, corners, block->cell_corners[i], faces, face_count, indices);
    if (result != SCREE_OK) return result;
    corners += block->cell_corners[i];
    for (uint32_t k = 0; k < face_count; ++k) indices += faces[k].count;
    faces += face_count;
  }
  return SCREE_OK;
}

/* Room for what random seeds make: some 7 vertices, 8 pieces and 41 corners a cell, fewer where the solid is but few cells across.
 */
static bool reserve(cutting* c, shard_pieces* out) {
  const scree_allocator* allocator = &c->input->allocator;
  const size_t half = c->input->seed_count / 2; /* for grow takes twice as much */
  return need_vertices(c, out, 7 * half) &&
         grow(allocator, &out->corners, &out->corner_capacity, 0, 42 * half, sizeof *out->corners) &&
         grow(allocator, &out->pieces, &out->piece_capacity, 0, 8 * half, sizeof *out->pieces);
}

static scree_result cut_and_join(cutting* c, shard_pieces* out) {
  const shard_input* input = c->input;
  for (uint64_t first = 0; first < input->seed_count; first += (uint64_t)c->block_count * BLOCK_CELLS) {
    const uint64_t left = (input->seed_count - first + BLOCK_CELLS - 1) / BLOCK_CELLS;
    const uint32_t count = left < c->block_count ? (uint32_t)left : c->block_count;
    c->first_seed = (uint32_t)first;
    if (input->jobs.parallel_for != NULL)
      input->jobs.parallel_for(input->jobs.user, count, cut_cells, c);
    else
      for (uint32_t i = 0; i < count; ++i) cut_cells(c, i, 0);
    for (uint32_t i = 0; i < count; ++i) {
      const scree_result result = join_block(c, out, i);
      if (result != SCREE_OK) return result;
    }
  }
  return c->awaited == c->met ? SCREE_OK : SCREE_ERROR_UNSUPPORTED;
}

/* --- all of it -------------------------------------------------------------------------------------------------------------- */

static void bound(cutting* c) {
  const shard_input* input = c->input;
  double longest = 0;
  points_bounds(input->positions, input->vertex_count, c->bounds.min, c->bounds.max);
  for (int axis = 0; axis < 3; ++axis) {
    const double length = c->bounds.max[axis] - c->bounds.min[axis];
    longest = length > longest ? length : longest;
  }
  /* Clear of the walls, so that none lies in a side of the box. */
  for (int axis = 0; axis < 3; ++axis) {
    c->bounds.min[axis] -= 0.125 * longest;
    c->bounds.max[axis] += 0.125 * longest;
  }
  c->bounds.walls = c->walls.walls;
  c->bounds.wall_count = c->walls.wall_count;
}

static void release(cutting* c, uint32_t key_capacity) {
  const scree_allocator* allocator = &c->input->allocator;
  for (uint32_t i = 0; c->cells != NULL && i < c->worker_count; ++i) voronoi_cell_free(c->cells + i);
  for (uint32_t i = 0; c->blocks != NULL && i < c->block_count; ++i) {
    cut_block* block = c->blocks + i;
    scree_rt_release(allocator, block->corners, block->corner_capacity, sizeof *block->corners);
    scree_rt_release(allocator, block->faces, block->face_capacity, sizeof *block->faces);
    scree_rt_release(allocator, block->indices, block->index_capacity, sizeof *block->indices);
  }
  scree_rt_release(allocator, c->cells, c->worker_count, sizeof *c->cells);
  scree_rt_release(allocator, c->blocks, c->block_count, sizeof *c->blocks);
  scree_rt_release(allocator, c->keys, key_capacity, sizeof *c->keys);
  scree_rt_release(allocator, c->seed_first, c->input->seed_count, sizeof *c->seed_first);
  scree_rt_release(allocator, c->seed_end, c->input->seed_count, sizeof *c->seed_end);
  scree_rt_release(allocator, c->solid_vertices, c->input->vertex_count, sizeof *c->solid_vertices);
  scree_rt_release(allocator, c->ids, c->id_capacity, sizeof *c->ids);
  convex_walls_free(&c->walls, allocator);
  voronoi_grid_free(&c->grid, allocator);
}

scree_result shard_walls_cut(const shard_input* input, shard_pieces* out) {
  const scree_allocator* allocator = &input->allocator;
  cutting c = {.input = input};
  *out = (shard_pieces){0};
  c.worker_count = input->jobs.parallel_for == NULL ? 1 : input->jobs.worker_count;
  c.block_count = c.worker_count == 1 ? 1 : MOST_BLOCKS;
  scree_result result = voronoi_grid_create(input->seeds, input->seed_count, allocator, &c.grid);
  if (result == SCREE_OK)
    result = convex_walls_create(input->positions, input->vertex_count, input->indices, input->triangle_count, allocator, &c.walls,
                                 NULL);
  if (result == SCREE_OK) {
    bound(&c);
    c.cells = scree_rt_allocate_zeroed(allocator, c.worker_count, sizeof *c.cells);
    c.blocks = scree_rt_allocate_zeroed(allocator, c.block_count, sizeof *c.blocks);
    c.seed_first = scree_rt_allocate_zeroed(allocator, input->seed_count, sizeof *c.seed_first);
    c.seed_end = scree_rt_allocate_zeroed(allocator, input->seed_count, sizeof *c.seed_end);
    c.solid_vertices = scree_rt_allocate(allocator, input->vertex_count, sizeof *c.solid_vertices);
    result = SCREE_ERROR_OUT_OF_MEMORY;
    if (c.cells != NULL && c.blocks != NULL && c.seed_first != NULL && c.seed_end != NULL && c.solid_vertices != NULL) {
      memset(c.solid_vertices, 0xff, input->vertex_count * sizeof *c.solid_vertices);
      if (reserve(&c, out)) result = cut_and_join(&c, out);
    }
  }
  release(&c, out->vertex_capacity);
  if (result != SCREE_OK) shard_pieces_free(out, allocator);
  return result;
}
