#include "surface_bricks.h"

#include <math.h>
#include <string.h>

#include "allocator.h"

/* Crossings keep this far from the ends of their edges, in voxels. */
#define MARGIN 0.015625f

enum {
  CELL_CONFIGURATION = 14,
  CELL_CUT = 22,
  CELL_COLLUVIUM = 23,
  CELL_VERTEX = (1 << CELL_CONFIGURATION) - 1,
  SLICE = BLOCK_WIDTH * BLOCK_SIDE
};

void run_jobs(const scree_jobs* jobs, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context) {
  if (jobs->parallel_for != NULL)
    jobs->parallel_for(jobs->user, count, run, context);
  else
    for (uint32_t i = 0; i < count; ++i) run(context, i, 0);
}

scree_result surface_mesher_create(const surface_source* source, const scree_jobs* jobs, const scree_allocator* allocator,
                                   surface_mesher* out) {
  memset(out, 0, sizeof *out);
  out->allocator = *allocator;
  out->jobs = *jobs;
  out->kernels = kernels_choose(false);
  out->source = *source;
  surface_cubes_fill(&out->table);
  out->brick_count = 1;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    out->bricks[axis] = source->size[axis] / BRICK_SIDE + 1; /* cubes 0 .. size */
    out->brick_count *= out->bricks[axis];
  }
  out->worker_count = jobs->parallel_for == NULL ? 1 : jobs->worker_count;
  out->brick = scree_rt_allocate_zeroed(allocator, out->brick_count, sizeof *out->brick);
  out->list = scree_rt_allocate(allocator, out->brick_count, sizeof *out->list);
  out->blocks = scree_rt_allocate_zeroed(allocator, out->worker_count, sizeof *out->blocks);
  if (out->brick == NULL || out->list == NULL || out->blocks == NULL) {
    surface_mesher_destroy(out);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  for (uint32_t b = 0; b < out->brick_count; ++b) out->brick[b].changed = true;
  return SCREE_OK;
}

static void brick_clear(const scree_allocator* allocator, surface_brick* brick) {
  scree_rt_release(allocator, brick->cells, BRICK_SIDE * BRICK_SIDE * BRICK_SIDE, sizeof *brick->cells);
  scree_rt_release(allocator, brick->cubes, brick->cube_capacity, sizeof *brick->cubes);
  scree_rt_release(allocator, brick->vertices, brick->vertex_capacity, sizeof *brick->vertices);
  memset(brick, 0, sizeof *brick);
}

void surface_mesher_destroy(surface_mesher* mesher) {
  const scree_allocator* allocator = &mesher->allocator;
  if (mesher->brick != NULL)
    for (uint32_t b = 0; b < mesher->brick_count; ++b) brick_clear(allocator, &mesher->brick[b]);
  scree_rt_release(allocator, mesher->brick, mesher->brick_count, sizeof *mesher->brick);
  scree_rt_release(allocator, mesher->list, mesher->brick_count, sizeof *mesher->list);
  scree_rt_release(allocator, mesher->blocks, mesher->worker_count, sizeof *mesher->blocks);
  scree_rt_release(allocator, mesher->vertices, mesher->vertex_capacity, sizeof *mesher->vertices);
  scree_rt_release(allocator, mesher->indices, mesher->index_capacity, sizeof *mesher->indices);
  memset(mesher, 0, sizeof *mesher);
}

void surface_mesher_touch(surface_mesher* mesher, const int32_t min[3], const int32_t max[3]) {
  uint32_t low[3], high[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    /* The vertices of cube c lie between c - 1/2 and c + 1/2. */
    low[axis] = min[axis] < 0 ? 0 : (uint32_t)min[axis] / BRICK_SIDE;
    high[axis] = (uint32_t)max[axis] / BRICK_SIDE;
    if (high[axis] >= mesher->bricks[axis]) high[axis] = mesher->bricks[axis] - 1;
  }
  for (uint32_t z = low[2]; z <= high[2]; ++z)
    for (uint32_t y = low[1]; y <= high[1]; ++y)
      for (uint32_t x = low[0]; x <= high[0]; ++x)
        mesher->brick[x + mesher->bricks[0] * (y + mesher->bricks[1] * z)].changed = true;
}

/* --- Blur. --- */

void surface_blur(float* raw, float* out) {
  enum { RAW_SLICE = BLOCK_WIDTH * RAW_SIDE };
  /* Along x in place: what comes to stand in the last columns is not looked at. */
  for (uint32_t row = 0; row < RAW_SIDE * RAW_SIDE; ++row) {
    float* v = raw + (size_t)row * BLOCK_WIDTH;
    for (uint32_t x = 0; x < BLOCK_SIDE; ++x) v[x] = (v[x] + 2 * v[x + 1] + v[x + 2]) * 0.25f;
  }
  for (uint32_t z = 0; z < RAW_SIDE; ++z)
    for (uint32_t y = 0; y < BLOCK_SIDE; ++y) {
      float* v = raw + (size_t)z * RAW_SLICE + (size_t)y * BLOCK_WIDTH;
      for (uint32_t x = 0; x < BLOCK_WIDTH; ++x) v[x] = (v[x] + 2 * v[x + BLOCK_WIDTH] + v[x + 2 * BLOCK_WIDTH]) * 0.25f;
    }
  for (uint32_t z = 0; z < BLOCK_SIDE; ++z)
    for (uint32_t y = 0; y < BLOCK_SIDE; ++y) {
      const float* v = raw + (size_t)z * RAW_SLICE + (size_t)y * BLOCK_WIDTH;
      float* to = out + (size_t)z * SLICE + (size_t)y * BLOCK_WIDTH;
      for (uint32_t x = 0; x < BLOCK_WIDTH; ++x) to[x] = (v[x] + 2 * v[x + RAW_SLICE] + v[x + 2 * RAW_SLICE]) * 0.25f;
    }
}

void surface_continue_below(float* field) {
  for (uint32_t z = 0; z < BLOCK_SIDE; ++z) {
    float *y0 = field + (size_t)z * SLICE + 2 * BLOCK_WIDTH, *below = y0 - BLOCK_WIDTH;
    const float* y1 = y0 + BLOCK_WIDTH;
    for (uint32_t x = 0; x < BLOCK_WIDTH; ++x) below[x] = 2 * y0[x] - y1[x];
  }
}

/* --- One brick's vertices. --- */

static uint32_t configuration(const uint64_t* rows, uint32_t x, uint32_t y, uint32_t z) {
  const uint64_t* at = rows + y + (size_t)BLOCK_SIDE * z;
  return (uint32_t)((at[0] >> x & 3) | (at[1] >> x & 3) << 2 | (at[BLOCK_SIDE] >> x & 3) << 4 | (at[BLOCK_SIDE + 1] >> x & 3) << 6);
}

/* Slope of the field at a vertex, trilinear between central differences at the corners of its cube. */
static void slope_at(const float* corner, const float t[3], float slope[3]) {
  static const int32_t step[3] = {1, BLOCK_WIDTH, SLICE};
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const int32_t d = step[axis];
    float g[8];
    for (uint32_t i = 0; i < 8; ++i) {
      const float* v = corner + (i & 1) + (i >> 1 & 1) * BLOCK_WIDTH + (i >> 2) * SLICE;
      g[i] = v[d] - *(v - d);
    }
    for (uint32_t i = 0; i < 4; ++i) g[i] = g[2 * i] + (g[2 * i + 1] - g[2 * i]) * t[0];
    g[0] += (g[1] - g[0]) * t[1];
    g[1] = g[2] + (g[3] - g[2]) * t[1];
    slope[axis] = g[0] + (g[1] - g[0]) * t[2];
  }
}

static void set_normal(const float inward[3], float normal[3]) {
  const float length2 = inward[0] * inward[0] + inward[1] * inward[1] + inward[2] * inward[2];
  if (length2 > 1e-12f) {
    const float scale = -1 / sqrtf(length2);
    for (uint32_t axis = 0; axis < 3; ++axis) normal[axis] = inward[axis] * scale;
  } else {
    normal[0] = normal[2] = 0;
    normal[1] = 1;
  }
}

/* A cube being made: its corner (0, 0, 0) in the block, and what is known of it. */
typedef struct cube_view {
  const surface_mesher* mesher;
  const float* corner; /* field */
  float origin[3];     /* position of its corner (0, 0, 0), in voxels */
  uint32_t inside, colluvium;
  bool ground; /* its lower corners lie below y = 0 */
} cube_view;

static void make_vertex(const cube_view* cube, uint32_t edges, scree_surface_vertex* out) {
  float sum[3] = {0, 0, 0}, t[3];
  uint32_t count = 0;
  bool colluvium = false, floor = true;
  for (uint32_t rest = edges; rest != 0; rest &= rest - 1) {
    const uint32_t edge = (uint32_t)__builtin_ctz(rest), axis = edge >> 2, low = cube_edge_low(edge), high = cube_edge_high(edge);
    colluvium = colluvium || (cube->colluvium >> (cube->inside >> low & 1 ? low : high) & 1) != 0;
    if (cube->ground && axis == 1) continue;
    floor = false;
    const float a = cube->corner[(low & 1) + (low >> 1 & 1) * BLOCK_WIDTH + (low >> 2) * SLICE];
    const float b = cube->corner[(high & 1) + (high >> 1 & 1) * BLOCK_WIDTH + (high >> 2) * SLICE];
    const float crossing = a / (a - b);
    sum[0] += (float)(low & 1);
    sum[1] += (float)(low >> 1 & 1);
    sum[2] += (float)(low >> 2);
    sum[axis] += crossing < MARGIN ? MARGIN : crossing > 1 - MARGIN ? 1 - MARGIN : crossing;
    ++count;
  }
  for (uint32_t axis = 0; axis < 3; ++axis) t[axis] = count > 0 ? sum[axis] / (float)count : 0.5f;
  memset(out, 0, sizeof *out);
  if (cube->ground) {
    t[1] = 0.5f;
    if (floor)
      out->normal[1] = -1;
    else { /* that of the wall half a voxel higher */
      float inward[3];
      slope_at(cube->corner + BLOCK_WIDTH, (const float[3]){t[0], 0.5f, t[2]}, inward);
      set_normal(inward, out->normal);
    }
  } else {
    float inward[3];
    slope_at(cube->corner, t, inward);
    set_normal(inward, out->normal);
  }
  const float width = cube->mesher->source.width;
  for (uint32_t axis = 0; axis < 3; ++axis) out->position[axis] = (cube->origin[axis] + t[axis]) * width;
  out->material = colluvium ? 1 : 0;
  cube->mesher->source.describe(cube->mesher->source.user, out);
}

/* The cubes that the surface passes, into block->cubes and, but for their vertices, into brick->cells. */
static void find_cubes(const surface_mesher* mesher, surface_block* block, surface_brick* brick, uint32_t* vertices) {
  static const int8_t direction[CUBE_FACES][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};
  const surface_cubes* table = &mesher->table;
  uint32_t count = 0;
  *vertices = 0;
  for (uint32_t z = 0; z < BRICK_SIDE; ++z)
    for (uint32_t y = 0; y < BRICK_SIDE; ++y) {
      const uint64_t* at = block->rows + (y + 1) + (size_t)BLOCK_SIDE * (z + 1);
      const uint64_t a = at[0], b = at[1], c = at[BLOCK_SIDE], d = at[BLOCK_SIDE + 1];
      const uint64_t any = a | b | c | d, all = a & b & c & d;
      for (uint64_t rest = ((any | any >> 1) & ~(all & all >> 1)) >> 1 & 0xffff; rest != 0; rest &= rest - 1) {
        const uint32_t x = (uint32_t)__builtin_ctzll(rest), inside = configuration(block->rows, x + 1, y + 1, z + 1);
        uint32_t cut = 0;
        const uint32_t face = table->pinching[inside];
        if (face != CUBE_NO_FACE) {
          const int8_t* to = direction[face];
          const uint32_t beyond = configuration(block->rows, (uint32_t)((int32_t)x + 1 + to[0]), (uint32_t)((int32_t)y + 1 + to[1]),
                                                (uint32_t)((int32_t)z + 1 + to[2]));
          cut = table->pinching[beyond] == (face ^ 1);
        }
        const uint32_t cube = x + BRICK_SIDE * (y + BRICK_SIDE * z);
        block->cubes[count++] = (uint16_t)cube;
        brick->cells[cube] = *vertices | inside << CELL_CONFIGURATION | cut << CELL_CUT;
        *vertices += table->pieces[cut][inside];
      }
    }
  brick->cube_count = count;
}

static bool reserve_brick(const scree_allocator* allocator, surface_brick* brick, uint32_t vertices) {
  if (brick->cube_count > brick->cube_capacity) {
    scree_rt_release(allocator, brick->cubes, brick->cube_capacity, sizeof *brick->cubes);
    brick->cube_capacity = brick->cube_count + brick->cube_count / 4;
    brick->cubes = scree_rt_allocate(allocator, brick->cube_capacity, sizeof *brick->cubes);
    if (brick->cubes == NULL) brick->cube_capacity = 0;
  }
  if (vertices > brick->vertex_capacity) {
    scree_rt_release(allocator, brick->vertices, brick->vertex_capacity, sizeof *brick->vertices);
    brick->vertex_capacity = vertices + vertices / 4;
    brick->vertices = scree_rt_allocate(allocator, brick->vertex_capacity, sizeof *brick->vertices);
    if (brick->vertices == NULL) brick->vertex_capacity = 0;
  }
  return brick->cubes != NULL && brick->vertices != NULL;
}

/* Corners 0..7 of a cube whose inside is more colluvium than rock. */
static uint32_t colluvium_corners(const surface_block* block, size_t corner) {
  uint32_t bits = 0;
  for (uint32_t i = 0; i < 8; ++i) {
    const size_t at = corner + (i & 1) + (i >> 1 & 1) * BLOCK_WIDTH + (i >> 2) * SLICE;
    bits |= (block->colluvium[at] * 2 > block->field[at] + 0.5f ? 1u : 0u) << i;
  }
  return bits;
}

static void make_cubes(const surface_mesher* mesher, const int32_t at[3], const surface_block* block, surface_brick* brick) {
  static const uint8_t ends[3] = {1, 2, 4};
  const surface_cubes* table = &mesher->table;
  brick->quads[0] = brick->quads[1] = 0;
  for (uint32_t k = 0; k < brick->cube_count; ++k) {
    const uint32_t x = brick->cubes[k] & 15, y = brick->cubes[k] >> 4 & 15, z = brick->cubes[k] >> 8;
    brick_cell* cell = &brick->cells[brick->cubes[k]];
    const size_t corner = (x + 1) + (size_t)BLOCK_WIDTH * (y + 1) + (size_t)SLICE * (z + 1);
    cube_view cube = {mesher, block->field + corner, {0}, *cell >> CELL_CONFIGURATION & 255, 0, at[1] == 0 && y == 0};
    if (block->has_colluvium) cube.colluvium = colluvium_corners(block, corner);
    cube.origin[0] = (float)(at[0] * BRICK_SIDE + (int32_t)x) - 0.5f;
    cube.origin[1] = (float)(at[1] * BRICK_SIDE + (int32_t)y) - 0.5f;
    cube.origin[2] = (float)(at[2] * BRICK_SIDE + (int32_t)z) - 0.5f;
    *cell |= ((cube.colluvium & 7) | (cube.colluvium >> 1 & 8)) << CELL_COLLUVIUM;
    const uint32_t cut = *cell >> CELL_CUT & 1, pieces = table->pieces[cut][cube.inside];
    scree_surface_vertex* vertices = brick->vertices + (*cell & CELL_VERTEX);
    for (uint32_t piece = 0; piece < pieces; ++piece) {
      uint32_t edges = table->crossed[cube.inside];
      if (pieces > 1)
        for (uint32_t edge = 0; edge < CUBE_EDGES; ++edge)
          if (table->piece[cut][cube.inside][edge] != piece) edges &= ~(1u << edge);
      make_vertex(&cube, edges, &vertices[piece]);
    }
    for (uint32_t axis = 0; axis < 3; ++axis)
      if ((cube.inside ^ cube.inside >> ends[axis]) & 1) ++brick->quads[cube.colluvium >> (cube.inside & 1 ? 0 : ends[axis]) & 1];
  }
}

static void make_brick(void* context, uint32_t index, uint32_t worker) {
  surface_mesher* mesher = context;
  const uint32_t b = mesher->list[index];
  surface_brick* brick = &mesher->brick[b];
  surface_block* block = &mesher->blocks[worker];
  const int32_t at[3] = {(int32_t)(b % mesher->bricks[0]), (int32_t)(b / mesher->bricks[0] % mesher->bricks[1]),
                         (int32_t)(b / mesher->bricks[0] / mesher->bricks[1])};
  brick->incomplete = false;
  brick->cube_count = brick->vertex_count = brick->quads[0] = brick->quads[1] = 0;
  bool passes = mesher->source.load(mesher->source.user, at, block);
  if (passes) {
    const uint64_t full = (UINT64_C(1) << BLOCK_SIDE) - 1;
    uint64_t any = 0, all = full;
    mesher->kernels->sign_rows(block->field, BLOCK_WIDTH, BLOCK_SIDE * BLOCK_SIDE, block->rows);
    for (uint32_t row = 0; row < BLOCK_SIDE * BLOCK_SIDE; ++row) {
      if (at[1] == 0 && row % BLOCK_SIDE < 2) block->rows[row] = 0;
      block->rows[row] &= full;
      any |= block->rows[row];
      all &= block->rows[row];
    }
    passes = any != 0 && all != full;
  }
  if (passes) {
    uint32_t vertices;
    if (brick->cells == NULL)
      brick->cells = scree_rt_allocate(&mesher->allocator, BRICK_SIDE * BRICK_SIDE * BRICK_SIDE, sizeof *brick->cells);
    if (brick->cells == NULL) {
      brick->incomplete = true;
      return;
    }
    find_cubes(mesher, block, brick, &vertices);
    if (vertices > 0 && !reserve_brick(&mesher->allocator, brick, vertices)) {
      brick->cube_count = 0;
      brick->incomplete = true;
      return;
    }
    brick->vertex_count = vertices;
    if (vertices > 0) {
      memcpy(brick->cubes, block->cubes, brick->cube_count * sizeof *brick->cubes);
      make_cubes(mesher, at, block, brick);
    }
  }
  if (brick->cube_count == 0) brick_clear(&mesher->allocator, brick);
  brick->changed = false;
}

/* --- The whole mesh. --- */

typedef struct quad_corner {
  uint32_t vertex; /* in the whole mesh */
  const float* position;
} quad_corner;

/* The vertex around an edge of the cube (x, y, z) of a brick; -1 is a cube of the brick before. */
static quad_corner corner_of(const surface_mesher* mesher, uint32_t b, int32_t x, int32_t y, int32_t z, uint32_t edge) {
  if (x < 0) b -= 1;
  if (y < 0) b -= mesher->bricks[0];
  if (z < 0) b -= mesher->bricks[0] * mesher->bricks[1];
  const surface_brick* brick = &mesher->brick[b];
  const brick_cell cell = brick->cells[(x & 15) + BRICK_SIDE * ((y & 15) + BRICK_SIDE * (z & 15))];
  const uint32_t vertex = (cell & CELL_VERTEX) + mesher->table.piece[cell >> CELL_CUT & 1][cell >> CELL_CONFIGURATION & 255][edge];
  return (quad_corner){brick->first_vertex + vertex, brick->vertices[vertex].position};
}

static float distance2(const float* a, const float* b) {
  const float x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
  return x * x + y * y + z * z;
}

static void cross(const float* a, const float* b, const float* c, float out[3]) {
  const float u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  out[0] = u[1] * w[2] - u[2] * w[1];
  out[1] = u[2] * w[0] - u[0] * w[2];
  out[2] = u[0] * w[1] - u[1] * w[0];
}

static float dot(const float* a, const float* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* How flat the fold between triangles abc and acd is: cosine of the angle between them, -1 if one has next to no area. */
static float fold(const float* a, const float* b, const float* c, const float* d) {
  float m[3], n[3];
  cross(a, b, c, m);
  cross(a, c, d, n);
  const float m2 = dot(m, m), n2 = dot(n, n), longest = distance2(a, c);
  const float least = longest * longest * 1e-6f;
  return m2 <= least || n2 <= least ? -1 : dot(m, n) / sqrtf(m2 * n2);
}

/* Along the shorter diagonal, unless that folds the quad sharply and the other one does less. */
static bool split_along_ac(const float* a, const float* b, const float* c, const float* d) {
  const bool shorter = distance2(a, c) <= distance2(b, d);
  const float sharp = shorter ? fold(a, b, c, d) : fold(b, c, d, a);
  if (sharp > 0.5f) return shorter;
  return (shorter ? fold(b, c, d, a) : fold(a, b, c, d)) > sharp ? !shorter : shorter;
}

/* The cubes around the edges from a cube's corner 0, counter-clockwise seen from the upper end, and the edge's number in each. */
static const struct {
  int8_t cube[4][3];
  uint8_t edge[4];
} around[3] = {
    {{{0, 0, 0}, {0, -1, 0}, {0, -1, -1}, {0, 0, -1}}, {0, 1, 3, 2}},
    {{{0, 0, 0}, {0, 0, -1}, {-1, 0, -1}, {-1, 0, 0}}, {4, 6, 7, 5}},
    {{{0, 0, 0}, {-1, 0, 0}, {-1, -1, 0}, {0, -1, 0}}, {8, 9, 11, 10}},
};

static void join_brick(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  surface_mesher* mesher = context;
  const uint32_t b = mesher->list[index];
  const surface_brick* brick = &mesher->brick[b];
  scree_surface_vertex* vertices = mesher->vertices + brick->first_vertex;
  memcpy(vertices, brick->vertices, brick->vertex_count * sizeof *vertices);
  if (mesher->source.sky != NULL)
    for (uint32_t v = 0; v < brick->vertex_count; ++v)
      vertices[v].occlusion = mesher->source.sky(mesher->source.user, &vertices[v]);
  uint32_t* to[2] = {mesher->indices + brick->first_index[0], mesher->indices + brick->first_index[1]};
  for (uint32_t k = 0; k < brick->cube_count; ++k) {
    const int32_t x = brick->cubes[k] & 15, y = brick->cubes[k] >> 4 & 15, z = brick->cubes[k] >> 8;
    const brick_cell cell = brick->cells[brick->cubes[k]];
    const uint32_t inside = cell >> CELL_CONFIGURATION & 255;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      if (((inside ^ inside >> (1u << axis)) & 1) == 0) continue;
      quad_corner q[4];
      for (uint32_t i = 0; i < 4; ++i) {
        const int8_t* cube = around[axis].cube[i];
        q[i] = corner_of(mesher, b, x + cube[0], y + cube[1], z + cube[2], around[axis].edge[i]);
      }
      const bool lower = (inside & 1) != 0;
      if (!lower) {
        const quad_corner swapped = q[1];
        q[1] = q[3];
        q[3] = swapped;
      }
      const uint32_t material = cell >> (CELL_COLLUVIUM + (lower ? 0 : axis + 1)) & 1;
      uint32_t* out = to[material];
      to[material] += 6;
      const uint32_t first = split_along_ac(q[0].position, q[1].position, q[2].position, q[3].position) ? 0 : 1;
      out[0] = out[3] = q[first].vertex;
      out[1] = q[first + 1].vertex;
      out[2] = out[4] = q[first + 2].vertex;
      out[5] = q[(first + 3) & 3].vertex;
    }
  }
}

static scree_result reserve_mesh(surface_mesher* mesher, uint32_t vertices, uint32_t indices) {
  const scree_allocator* allocator = &mesher->allocator;
  if (vertices > mesher->vertex_capacity) {
    scree_rt_release(allocator, mesher->vertices, mesher->vertex_capacity, sizeof *mesher->vertices);
    mesher->vertex_capacity = vertices + vertices / 8;
    mesher->vertices = scree_rt_allocate(allocator, mesher->vertex_capacity, sizeof *mesher->vertices);
    if (mesher->vertices == NULL) mesher->vertex_capacity = 0;
  }
  if (indices > mesher->index_capacity) {
    scree_rt_release(allocator, mesher->indices, mesher->index_capacity, sizeof *mesher->indices);
    mesher->index_capacity = indices + indices / 8;
    mesher->indices = scree_rt_allocate(allocator, mesher->index_capacity, sizeof *mesher->indices);
    if (mesher->indices == NULL) mesher->index_capacity = 0;
  }
  return vertices <= mesher->vertex_capacity && indices <= mesher->index_capacity ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

scree_result surface_mesher_update(surface_mesher* mesher, scree_surface* out) {
  *out = (scree_surface){0};
  uint32_t count = 0;
  for (uint32_t b = 0; b < mesher->brick_count; ++b)
    if (mesher->brick[b].changed) mesher->list[count++] = b;
  run_jobs(&mesher->jobs, count, make_brick, mesher);
  uint32_t vertices = 0, indices[2] = {0, 0};
  count = 0;
  for (uint32_t b = 0; b < mesher->brick_count; ++b) {
    surface_brick* brick = &mesher->brick[b];
    if (brick->incomplete) return SCREE_ERROR_OUT_OF_MEMORY;
    if (brick->cube_count == 0) continue;
    mesher->list[count++] = b;
    brick->first_vertex = vertices;
    vertices += brick->vertex_count;
    for (uint32_t m = 0; m < 2; ++m) {
      brick->first_index[m] = indices[m];
      indices[m] += brick->quads[m] * 6;
    }
  }
  const scree_result result = reserve_mesh(mesher, vertices, indices[0] + indices[1]);
  if (result != SCREE_OK) return result;
  for (uint32_t i = 0; i < count; ++i) mesher->brick[mesher->list[i]].first_index[1] += indices[0];
  run_jobs(&mesher->jobs, count, join_brick, mesher);
  *out = (scree_surface){mesher->vertices, mesher->indices, vertices, indices[0] / 3, indices[1] / 3};
  return SCREE_OK;
}

double surface_volume(const scree_surface* surface) {
  double volume6 = 0;
  const uint32_t count = (surface->rock_triangles + surface->colluvium_triangles) * 3;
  if (count == 0) return 0;
  const float* origin = surface->vertices[0].position;
  for (uint32_t i = 0; i < count; i += 3) {
    double p[3][3];
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t axis = 0; axis < 3; ++axis)
        p[k][axis] = (double)surface->vertices[surface->indices[i + k]].position[axis] - (double)origin[axis];
    volume6 += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
               p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return volume6 / 6;
}

/* Moves all vertices by `step` along their normals, from where the bricks have them. */
static void move_vertices(surface_mesher* mesher, float step) {
  for (uint32_t b = 0; b < mesher->brick_count; ++b) {
    const surface_brick* brick = &mesher->brick[b];
    for (uint32_t v = 0; v < brick->vertex_count; ++v) {
      const scree_surface_vertex* from = &brick->vertices[v];
      scree_surface_vertex* to = &mesher->vertices[brick->first_vertex + v];
      for (uint32_t axis = 0; axis < 3; ++axis) to->position[axis] = from->position[axis] + from->normal[axis] * step;
      if (from->position[1] == 0 || to->position[1] < 0) to->position[1] = from->position[1];
    }
  }
}

/* Whether some triangle has turned over, or lost nearly all its area. */
static bool is_turned(const surface_mesher* mesher, const scree_surface* surface, const float (*before)[3]) {
  const uint32_t count = (surface->rock_triangles + surface->colluvium_triangles) * 3;
  for (uint32_t i = 0; i < count; i += 3) {
    const uint32_t* v = surface->indices + i;
    float m[3], n[3];
    cross(before[v[0]], before[v[1]], before[v[2]], m);
    cross(mesher->vertices[v[0]].position, mesher->vertices[v[1]].position, mesher->vertices[v[2]].position, n);
    if (dot(m, n) < 0.01f * dot(m, m)) return true;
  }
  return false;
}

scree_result surface_match_volume(surface_mesher* mesher, const scree_surface* surface, double wanted, float most) {
  const uint32_t count = surface->vertex_count;
  float(*before)[3] = scree_rt_allocate(&mesher->allocator, count, sizeof *before);
  if (before == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (uint32_t v = 0; v < count; ++v) memcpy(before[v], mesher->vertices[v].position, sizeof *before);
  const double start = surface_volume(surface);
  const float trial = 0.1f * most;
  float step = trial;
  double volume = start;
  for (uint32_t iteration = 0; iteration < 3; ++iteration) { /* secants through the start */
    move_vertices(mesher, step);
    volume = surface_volume(surface) - start;
    if (volume == 0 || (volume > 0) != (step > 0)) break;
    step *= (float)((wanted - start) / volume);
    step = step > most ? most : step < -most ? -most : step;
    if (step == 0) break;
  }
  for (uint32_t half = 0; half < 4; ++half) {
    move_vertices(mesher, step);
    if (!is_turned(mesher, surface, (const float(*)[3])before)) break;
    step = half < 2 ? step * 0.5f : 0;
  }
  scree_rt_release(&mesher->allocator, before, count, sizeof *before);
  return SCREE_OK;
}
