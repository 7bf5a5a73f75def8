/* Marching cubes that are a closed manifold for any set of samples and cross themselves nowhere but, at worst, within one cube with
 * two pieces of surface: vertices lie on the edges of the grid, off their ends; on each face of a cube they are joined by lines
 * that do not cross, told by that face's four samples alone, so that both cubes of a face agree; and within a cube each loop of
 * such lines becomes a fan round its middle, or two triangles.
 *
 * Dual meshes (surface_bricks.h) have better triangles, but theirs reach into neighbouring cubes and may cross each other there:
 * what is cut into shards must not. */
#include "solid_mesh.h"

#include <math.h>
#include <string.h>

#include "recipe_text.h"
#include "support_program.h"
#include "surface_cubes.h"

#define EDGE_MARGIN 0.03125 /* of a step: vertices keep off samples, so that no triangle is without area */

/* The loops of surface in a cube, by which of its corners are inside: edges in order, counter-clockwise from outside. */
typedef struct cube_loops {
  uint8_t count, length[4], edges[CUBE_EDGES];
} cube_loops;

typedef struct loop_table {
  cube_loops loops[256];
  uint8_t faces[CUBE_EDGES]; /* a bit for each face that an edge lies in */
} loop_table;

static uint8_t edge_between(uint32_t a, uint32_t b) {
  for (uint8_t edge = 0;; ++edge)
    if ((cube_edge_low(edge) == a && cube_edge_high(edge) == b) || (cube_edge_low(edge) == b && cube_edge_high(edge) == a))
      return edge;
}

static void fill_table(loop_table* out) {
  memset(out, 0, sizeof *out);
  uint32_t corners[CUBE_FACES][4]; /* counter-clockwise seen from outside the cube */
  uint8_t edges[CUBE_FACES][4];    /* from corner k to the next */
  for (uint32_t f = 0; f < CUBE_FACES; ++f) {
    const uint32_t axis = f >> 1, side = f & 1, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, at = side << axis;
    corners[f][0] = at, corners[f][2] = at | u | v;
    corners[f][1] = at | (side ? u : v), corners[f][3] = at | (side ? v : u);
    for (uint32_t k = 0; k < 4; ++k) {
      edges[f][k] = edge_between(corners[f][k], corners[f][(k + 1) & 3]);
      out->faces[edges[f][k]] |= (uint8_t)(1u << f);
    }
  }
  for (uint32_t inside = 0; inside < 256; ++inside) {
    uint8_t next[CUBE_EDGES];
    memset(next, CUBE_EDGES, sizeof next);
    for (uint32_t f = 0; f < CUBE_FACES; ++f) {
      /* Each run of inside corners is cut off, from the edge that enters it to the one that leaves it. */
      for (uint32_t k = 0; k < 4; ++k) {
        const bool here = (inside >> corners[f][k] & 1) != 0, then = (inside >> corners[f][(k + 1) & 3] & 1) != 0;
        if (here || !then) continue;
        uint32_t leave = (k + 1) & 3;
        while (inside >> corners[f][(leave + 1) & 3] & 1) leave = (leave + 1) & 3;
        next[edges[f][k]] = edges[f][leave];
      }
    }
    cube_loops* loops = &out->loops[inside];
    uint32_t at = 0;
    for (uint32_t first = 0; first < CUBE_EDGES; ++first) {
      if (next[first] == CUBE_EDGES) continue;
      const uint32_t start = at;
      for (uint32_t edge = first; next[edge] != CUBE_EDGES;) {
        loops->edges[at++] = (uint8_t)edge;
        const uint32_t then = next[edge];
        next[edge] = CUBE_EDGES;
        edge = then;
      }
      loops->length[loops->count++] = (uint8_t)(at - start);
    }
  }
}

/* A mesh that grows. */
typedef struct mesh_growth {
  const scree_allocator* allocator;
  double* positions;
  uint32_t* indices;
  size_t vertices, vertex_capacity, triangles, triangle_capacity;
  bool failed; /* out of memory */
} mesh_growth;

static bool grow(mesh_growth* m, void** memory, size_t* capacity, size_t size) {
  const size_t wanted = *capacity < 4096 ? 4096 : 2 * *capacity;
  void* more = scree_rt_allocate(m->allocator, wanted, size);
  if (more == NULL) {
    m->failed = true;
    return false;
  }
  if (*capacity > 0) memcpy(more, *memory, *capacity * size);
  scree_rt_release(m->allocator, *memory, *capacity, size);
  *memory = more;
  *capacity = wanted;
  return true;
}

static uint32_t put_vertex(mesh_growth* m, const double p[3]) {
  void* memory = m->positions;
  if (m->vertices == m->vertex_capacity && !grow(m, &memory, &m->vertex_capacity, 3 * sizeof *p)) return 0;
  m->positions = memory;
  memcpy(m->positions + 3 * m->vertices, p, 3 * sizeof *p);
  return (uint32_t)m->vertices++;
}

static void put_triangle(mesh_growth* m, uint32_t a, uint32_t b, uint32_t c) {
  void* memory = m->indices;
  if (m->triangles == m->triangle_capacity && !grow(m, &memory, &m->triangle_capacity, 3 * sizeof a)) return;
  m->indices = memory;
  uint32_t* v = m->indices + 3 * m->triangles++;
  v[0] = a, v[1] = b, v[2] = c;
}

static double distance2(const mesh_growth* m, uint32_t a, uint32_t b) {
  double sum = 0;
  for (size_t i = 0; i < 3; ++i) {
    const double d = m->positions[3 * (size_t)a + i] - m->positions[3 * (size_t)b + i];
    sum += d * d;
  }
  return sum;
}

static void put_loop(mesh_growth* m, const loop_table* table, const uint8_t* edges, uint32_t length, const uint32_t* vertex) {
  uint32_t v[CUBE_EDGES];
  for (uint32_t k = 0; k < length; ++k) v[k] = vertex[edges[k]];
  if (m->failed) return;
  if (length == 3) {
    put_triangle(m, v[0], v[1], v[2]);
    return;
  }
  if (length == 4) { /* a diagonal must run within the cube: on a face it could be another line's */
    const bool first = (table->faces[edges[0]] & table->faces[edges[2]]) == 0;
    const bool second = (table->faces[edges[1]] & table->faces[edges[3]]) == 0;
    if (first && (!second || distance2(m, v[0], v[2]) <= distance2(m, v[1], v[3]))) {
      put_triangle(m, v[0], v[1], v[2]), put_triangle(m, v[0], v[2], v[3]);
      return;
    }
    if (second) {
      put_triangle(m, v[1], v[2], v[3]), put_triangle(m, v[1], v[3], v[0]);
      return;
    }
  }
  double middle[3] = {0, 0, 0};
  for (uint32_t k = 0; k < length; ++k)
    for (size_t a = 0; a < 3; ++a) middle[a] += m->positions[3 * (size_t)v[k] + a] / length;
  const uint32_t centre = put_vertex(m, middle);
  for (uint32_t k = 0; k < length; ++k) put_triangle(m, centre, v[k], v[(k + 1) % length]);
}

/* The edges of two layers of samples and those between: vertices by sample, of the layer z in [z & 1]. */
typedef struct edge_layers {
  uint32_t *along_x[2], *along_y[2], *along_z[2]; /* along_z: from the layer upwards */
} edge_layers;

static void put_edges(const solid_source* source, const solid_grid* grid, uint32_t z, edge_layers* layers, mesh_growth* m) {
  const size_t steps[3] = {1, grid->size[0], (size_t)grid->size[0] * grid->size[1]};
  uint32_t* const vertices[3] = {layers->along_x[z & 1], layers->along_y[z & 1], layers->along_z[z & 1]};
  for (uint32_t y = 0; y < grid->size[1]; ++y)
    for (uint32_t x = 0; x < grid->size[0]; ++x) {
      const uint32_t at[3] = {x, y, z};
      const size_t sample = solid_grid_at(grid, x, y, z);
      const bool inside = solid_grid_has(grid, sample);
      for (int a = 0; a < 3; ++a) {
        if (at[a] + 1 == grid->size[a] || solid_grid_has(grid, sample + steps[a]) == inside) continue;
        double p[3], q[3];
        solid_grid_place(grid, x, y, z, p);
        memcpy(q, p, sizeof q);
        q[a] = grid->min[a] + (at[a] + 1) * grid->step;
        double t = inside ? source->surface(source->user, p, q) : 1 - source->surface(source->user, q, p);
        t = t > EDGE_MARGIN ? t < 1 - EDGE_MARGIN ? t : 1 - EDGE_MARGIN : EDGE_MARGIN;
        p[a] += t * grid->step;
        vertices[a][(size_t)y * grid->size[0] + x] = put_vertex(m, p);
      }
    }
}

static void put_cubes(const solid_grid* grid, uint32_t z, const edge_layers* layers, const loop_table* table, mesh_growth* m) {
  for (uint32_t y = 0; y + 1 < grid->size[1]; ++y)
    for (uint32_t x = 0; x + 1 < grid->size[0]; ++x) {
      uint32_t inside = 0;
      for (uint32_t k = 0; k < 8; ++k)
        inside |= (uint32_t)solid_grid_has(grid, solid_grid_at(grid, x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))) << k;
      if (inside == 0 || inside == 255) continue;
      uint32_t vertex[CUBE_EDGES];
      for (uint32_t edge = 0; edge < CUBE_EDGES; ++edge) {
        const uint32_t low = cube_edge_low(edge), layer = (z + (low >> 2)) & 1;
        const uint32_t* from = edge < 4 ? layers->along_x[layer] : edge < 8 ? layers->along_y[layer] : layers->along_z[layer];
        vertex[edge] = from[(size_t)(y + (low >> 1 & 1)) * grid->size[0] + x + (low & 1)];
      }
      const cube_loops* loops = &table->loops[inside];
      const uint8_t* edges = loops->edges;
      for (uint32_t k = 0; k < loops->count; edges += loops->length[k++]) put_loop(m, table, edges, loops->length[k], vertex);
    }
}

static void march(const solid_source* source, const solid_grid* grid, uint32_t* scratch, mesh_growth* m) {
  const size_t layer = (size_t)grid->size[0] * grid->size[1];
  edge_layers layers;
  for (int i = 0; i < 2; ++i) {
    layers.along_x[i] = scratch + (size_t)(3 * i) * layer;
    layers.along_y[i] = layers.along_x[i] + layer;
    layers.along_z[i] = layers.along_y[i] + layer;
  }
  loop_table table;
  fill_table(&table);
  put_edges(source, grid, 0, &layers, m);
  for (uint32_t z = 0; z + 1 < grid->size[2] && !m->failed; ++z) {
    put_edges(source, grid, z + 1, &layers, m);
    put_cubes(grid, z, &layers, &table, m);
  }
}

static void clear_border(solid_grid* grid) {
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t y = 0; y < grid->size[1]; ++y) {
      const bool whole = y == 0 || z == 0 || y == grid->size[1] - 1 || z == grid->size[2] - 1;
      for (uint32_t x = 0; x < grid->size[0]; x += whole ? 1 : grid->size[0] - 1) {
        const size_t at = solid_grid_at(grid, x, y, z);
        grid->inside[at >> 6] &= ~(UINT64_C(1) << (at & 63));
      }
    }
}

static scree_result no_memory(const char* what, scree_error* error) {
  recipe_say(error, "%s: out of memory", what);
  return SCREE_ERROR_OUT_OF_MEMORY;
}

static scree_result keep(const mesh_growth* m, const char* what, const scree_allocator* allocator, scree_solid_memory* out,
                         scree_error* error) {
  if (m->failed) return no_memory(what, error);
  if (m->triangles == 0) {
    recipe_say(error, "%s: nothing of it is inside", what);
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  const scree_result result = solid_memory_create(m->vertices, m->triangles, false, allocator, out, error);
  if (result != SCREE_OK) return result;
  memcpy(solid_positions(out), m->positions, 3 * m->vertices * sizeof *m->positions);
  memcpy(solid_indices(out), m->indices, 3 * m->triangles * sizeof *m->indices);
  return SCREE_OK;
}

scree_result solid_mesh(const solid_source* source, const double min[3], const double max[3], uint32_t resolution, const char* what,
                        const scree_allocator* allocator, scree_solid_memory* out, scree_error* error) {
  double longest = 0;
  for (int a = 0; a < 3; ++a) longest = fmax(longest, max[a] - min[a]);
  solid_grid grid = {.step = longest / resolution};
  for (int a = 0; a < 3; ++a) {
    grid.size[a] = (uint32_t)floor((max[a] - min[a]) / grid.step) + 4;
    grid.min[a] = (min[a] + max[a]) / 2 - (grid.size[a] - 1) * grid.step / 2;
  }
  for (int a = 0; a < 3; ++a)
    if (grid.min[a] < -SOLID_LIMIT || grid.min[a] + (grid.size[a] - 1) * grid.step > SOLID_LIMIT) {
      recipe_say(error, "%s: too near to 1e6 to be meshed", what);
      return SCREE_ERROR_RANGE;
    }
  const size_t layer = (size_t)grid.size[0] * grid.size[1], words = (layer * grid.size[2] + 63) / 64;
  grid.inside = scree_rt_allocate_zeroed(allocator, words, sizeof *grid.inside);
  uint32_t* scratch = scree_rt_allocate_zeroed(allocator, 6 * layer, sizeof *scratch);
  mesh_growth mesh = {.allocator = allocator};
  mesh.failed = grid.inside == NULL || scratch == NULL || !source->fill(source->user, &grid);
  if (!mesh.failed) {
    clear_border(&grid);
    march(source, &grid, scratch, &mesh);
  }
  const scree_result result = keep(&mesh, what, allocator, out, error);
  scree_rt_release(allocator, mesh.positions, mesh.vertex_capacity, 3 * sizeof *mesh.positions);
  scree_rt_release(allocator, mesh.indices, mesh.triangle_capacity, 3 * sizeof *mesh.indices);
  scree_rt_release(allocator, scratch, 6 * layer, sizeof *scratch);
  scree_rt_release(allocator, grid.inside, words, sizeof *grid.inside);
  return result;
}

/* --- supports --------------------------------------------------------------------------------------------------------------- */

enum { DISTANCES = 64 };

static bool fill_from_support(void* user, solid_grid* grid) {
  const scree_support* support = user;
  for (uint32_t z = 0; z < grid->size[2]; ++z)
    for (uint32_t y = 0; y < grid->size[1]; ++y)
      for (uint32_t x = 0; x < grid->size[0]; x += DISTANCES) {
        const uint32_t count = grid->size[0] - x < DISTANCES ? grid->size[0] - x : DISTANCES;
        float p[3][DISTANCES], distance[DISTANCES];
        for (uint32_t i = 0; i < count; ++i) {
          double q[3];
          solid_grid_place(grid, x + i, y, z, q);
          for (int a = 0; a < 3; ++a) p[a][i] = (float)(q[a] - support->origin[a]);
        }
        scree_support_distance(support, p[0], p[1], p[2], distance, count);
        for (uint32_t i = 0; i < count; ++i)
          if (distance[i] <= 0) solid_grid_set(grid, solid_grid_at(grid, x + i, y, z));
      }
  return true;
}

static double support_distance(const scree_support* support, const double p[3], const double q[3], double t) {
  float at[3], distance;
  for (int a = 0; a < 3; ++a) at[a] = (float)(p[a] + t * (q[a] - p[a]) - support->origin[a]);
  scree_support_distance(support, &at[0], &at[1], &at[2], &distance, 1);
  return (double)distance;
}

/* Where a line through two distances is 0, halved in between lest one end never moves. */
static double find_distance_0(void* user, const double p[3], const double q[3]) {
  const scree_support* support = user;
  double low = 0, high = 1, at_low = support_distance(support, p, q, 0), at_high = support_distance(support, p, q, 1);
  for (int i = 0; i < 6; ++i) {
    double t = i % 2 == 0 && at_high > at_low ? low + (high - low) * (at_low / (at_low - at_high)) : (low + high) / 2;
    if (!(t > low && t < high)) t = (low + high) / 2;
    const double d = support_distance(support, p, q, t);
    if (d <= 0)
      low = t, at_low = d;
    else
      high = t, at_high = d;
  }
  const double t = low + (high - low) * (at_low / (at_low - at_high));
  return t >= low && t <= high ? t : (low + high) / 2;
}

static scree_result check_resolution(uint32_t resolution, const char* what, scree_error* error) {
  if (resolution >= 8 && resolution <= 512) return SCREE_OK;
  recipe_say(error, "%s: resolution must be 8..512, not %u", what, resolution);
  return SCREE_ERROR_RANGE;
}

scree_result scree_solid_from_support(const scree_support* support, uint32_t resolution, const scree_allocator* allocator,
                                      scree_solid_memory* out, scree_error* error) {
  static const char what[] = "support";
  if (out != NULL) memset(out, 0, sizeof *out);
  if (support == NULL || out == NULL) {
    recipe_say(error, "%s: none was given", what);
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  const scree_result result = check_resolution(resolution, what, error);
  if (result != SCREE_OK) return result;
  double min[3], max[3];
  scree_support_bounds(support, min, max);
  for (int a = 0; a < 3; ++a) {
    if (!(max[a] > min[a])) {
      recipe_say(error, "%s: nothing of it is inside", what);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    if (!isfinite(min[a]) || !isfinite(max[a])) {
      recipe_say(error, "%s: it has no end; cut it to size with an intersection", what);
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    if (fabs(min[a]) > SOLID_LIMIT || fabs(max[a]) > SOLID_LIMIT) {
      recipe_say(error, "%s: reaches to %g, beyond 1e6", what, fabs(min[a]) > SOLID_LIMIT ? min[a] : max[a]);
      return SCREE_ERROR_RANGE;
    }
  }
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  const solid_source source = {(void*)(uintptr_t)support, fill_from_support, find_distance_0};
  return solid_mesh(&source, min, max, resolution, what, &memory, out, error);
}
