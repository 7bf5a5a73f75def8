/* Samples the signed distance of a closed mesh.
 * Based on: Baerentzen and Aanaes, Signed Distance Computation Using the Angle Weighted Pseudonormal, 2005, for the problem;
 * Bridson, SDFGen, for the order of work: exact distances near the surface, nearest triangles handed on from sample to sample
 * elsewhere, signs by counting crossings along rows. Where we differ: vertices are snapped to a fine integer lattice, so that the
 * crossings are counted exactly; winding numbers instead of parity, so that overlapping parts unite; passes along one axis at a
 * time instead of sweeps, so that rows are independent and can be shared out.
 *
 * All work is in grid units: sample (i, j, k) lies at the point (i, j, k). */
#include "support_mesh.h"

#include <math.h>
#include <string.h>

#include "allocator.h"

enum {
  PADDING = 2,       /* samples around the mesh's box */
  LATTICE = 1 << 20, /* steps between samples to which vertices snap; 2^9 samples and 2^20 steps leave products within 2^61 */
  NO_TRIANGLE = INT32_MAX,
  ROWS_PER_JOB = 8,
  ROUNDS = 4
};

/* Nearer than this to the surface every sample is exact: all corners of a cell that the surface cuts, and then some. */
#define BAND 1.8

typedef struct vec3 {
  double x, y, z;
} vec3;

static vec3 sub(vec3 a, vec3 b) {
  return (vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}
static double dot(vec3 a, vec3 b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec3 along(vec3 a, vec3 b, double t) {
  return (vec3){a.x + t * b.x, a.y + t * b.y, a.z + t * b.z};
}
static double ratio(double a, double b) {
  return b > 0 ? a / b : 0;
}
static double least(double a, double b) {
  return a < b ? a : b;
}
static double most(double a, double b) {
  return a > b ? a : b;
}
static float steeper(float slope, float a, float b) {
  return fabsf(a - b) > slope ? fabsf(a - b) : slope;
}

typedef struct builder {
  const uint32_t* indices;
  uint32_t triangle_count;
  int32_t (*vertices)[3]; /* lattice steps */
  uint32_t size[3];
  float* distance;  /* of each sample to `nearest`, grid units, >= 0 */
  int32_t* nearest; /* triangle, or NO_TRIANGLE; before that: crossings of the row just before the sample */
  uint8_t* inside;  /* one bit a sample */
  uint8_t* changed; /* of each sample: the pass that last gave it a nearer triangle */
  int axis, pass;   /* the axis that is gone along, and the number of the way there; the way back has the next */
} builder;

static vec3 corner(const builder* b, uint32_t triangle, int k) {
  const int32_t* v = b->vertices[b->indices[(size_t)3 * triangle + k]];
  return (vec3){v[0] * (1.0 / LATTICE), v[1] * (1.0 / LATTICE), v[2] * (1.0 / LATTICE)};
}

/* Squared distance of p and a triangle. After Ericson, Real-Time Collision Detection, 5.1.5. */
static double triangle_distance2(vec3 p, vec3 a, vec3 b, vec3 c) {
  vec3 ab = sub(b, a), ac = sub(c, a), ap = sub(p, a), bp = sub(p, b), cp = sub(p, c), q;
  double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp), d6 = dot(ac, cp);
  double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (d1 <= 0 && d2 <= 0) {
    q = a;
  } else if (d3 >= 0 && d4 <= d3) {
    q = b;
  } else if (d6 >= 0 && d5 <= d6) {
    q = c;
  } else if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    q = along(a, ab, ratio(d1, d1 - d3));
  } else if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    q = along(a, ac, ratio(d2, d2 - d6));
  } else if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    q = along(b, sub(c, b), ratio(d4 - d3, (d4 - d3) + (d5 - d6)));
  } else {
    double sum = va + vb + vc;
    q = along(along(a, ab, ratio(vb, sum)), ac, ratio(vc, sum));
  }
  vec3 away = sub(p, q);
  return dot(away, away);
}

static float sample_distance(const builder* b, uint32_t triangle, vec3 p) {
  return (float)sqrt(triangle_distance2(p, corner(b, triangle, 0), corner(b, triangle, 1), corner(b, triangle, 2)));
}

/* --- signs ----------------------------------------------------------------------------------------------------------------- */

/* Which side of the line from p to q, both relative to the point, the point lies on: the sign of py qx - px qy, exactly. A point on
 * the line is taken a little to one side, the same side for all lines, so that a row passes through an edge or a vertex cleanly. */
static int side_of_line(int64_t px, int64_t py, int64_t qx, int64_t qy, int64_t* area) {
  *area = py * qx - px * qy;
  if (*area != 0) return *area > 0 ? 1 : -1;
  if (qy != py) return qy > py ? 1 : -1;
  return px == qx ? 0 : px > qx ? 1 : -1;
}

static int64_t floor_to_sample(int64_t steps) {
  return steps >= 0 ? steps / LATTICE : -((-steps + LATTICE - 1) / LATTICE);
}

static int64_t least3(int64_t a, int64_t b, int64_t c) {
  return a < b ? (a < c ? a : c) : (b < c ? b : c);
}
static int64_t most3(int64_t a, int64_t b, int64_t c) {
  return -least3(-a, -b, -c);
}

/* Adds the crossing of row (j, k) with a triangle, if there is one, where the samples behind it begin. */
static void cross_row(builder* b, const int32_t* p, const int32_t* q, const int32_t* r, int64_t j, int64_t k) {
  int64_t y = j * LATTICE, z = k * LATTICE, areas[3];
  int side = side_of_line(q[1] - y, q[2] - z, r[1] - y, r[2] - z, &areas[0]);
  if (side == 0 || side_of_line(r[1] - y, r[2] - z, p[1] - y, p[2] - z, &areas[1]) != side ||
      side_of_line(p[1] - y, p[2] - z, q[1] - y, q[2] - z, &areas[2]) != side)
    return;
  double sum = (double)areas[0] + (double)areas[1] + (double)areas[2];
  double x = ((double)areas[0] * p[0] + (double)areas[1] * q[0] + (double)areas[2] * r[0]) / sum / LATTICE;
  double first = floor(x) + 1;
  if (!(first > 0)) first = 0;
  if (first >= b->size[0]) return;
  b->nearest[((size_t)k * b->size[1] + (size_t)j) * b->size[0] + (size_t)first] += side;
}

/* Rows with k in [low, high). */
static void count_crossings(builder* b, int64_t low, int64_t high) {
  size_t first = (size_t)low * b->size[1] * b->size[0], end = (size_t)high * b->size[1] * b->size[0];
  memset(b->nearest + first, 0, (end - first) * sizeof *b->nearest);
  for (uint32_t t = 0; t < b->triangle_count; ++t) {
    const uint32_t* v = b->indices + (size_t)3 * t;
    const int32_t *p = b->vertices[v[0]], *q = b->vertices[v[1]], *r = b->vertices[v[2]];
    int64_t k_low = floor_to_sample(least3(p[2], q[2], r[2])), k_high = floor_to_sample(most3(p[2], q[2], r[2]));
    int64_t j_low = floor_to_sample(least3(p[1], q[1], r[1])), j_high = floor_to_sample(most3(p[1], q[1], r[1]));
    if (k_low < low) k_low = low;
    if (k_high > high - 1) k_high = high - 1;
    for (int64_t k = k_low; k <= k_high; ++k)
      for (int64_t j = j_low; j <= j_high; ++j) cross_row(b, p, q, r, j, k);
  }
  for (size_t row = first; row < end; row += b->size[0]) {
    int32_t winding = 0;
    for (uint32_t i = 0; i < b->size[0]; ++i) {
      winding += b->nearest[row + i];
      b->nearest[row + i] = winding;
    }
  }
}

/* --- distances ------------------------------------------------------------------------------------------------------------- */

static bool offer(builder* b, size_t sample, uint32_t triangle, vec3 p) {
  float d = sample_distance(b, triangle, p);
  if (!(d < b->distance[sample])) return false;
  b->distance[sample] = d;
  b->nearest[sample] = (int32_t)triangle;
  return true;
}

/* Offers a triangle to all samples with k in [low, high) that are within BAND of its plane and of its box. */
static void offer_nearby(builder* b, uint32_t triangle, int64_t low, int64_t high) {
  vec3 c[3] = {corner(b, triangle, 0), corner(b, triangle, 1), corner(b, triangle, 2)};
  vec3 ab = sub(c[1], c[0]), ac = sub(c[2], c[0]);
  vec3 normal = {ab.y * ac.z - ab.z * ac.y, ab.z * ac.x - ab.x * ac.z, ab.x * ac.y - ab.y * ac.x};
  double length = sqrt(dot(normal, normal));
  if (length == 0) return; /* has no area: its edges are those of its neighbours */
  normal = (vec3){normal.x / length, normal.y / length, normal.z / length};
  double offset = dot(normal, c[0]);

  int64_t first[3], last[3];
  const double* p[3] = {&c[0].x, &c[1].x, &c[2].x};
  for (int a = 0; a < 3; ++a) {
    double from = least(p[0][a], least(p[1][a], p[2][a])), to = most(p[0][a], most(p[1][a], p[2][a]));
    first[a] = (int64_t)most(ceil(from - BAND), a == 2 ? (double)low : 0);
    last[a] = (int64_t)least(floor(to + BAND), a == 2 ? (double)high - 1 : (double)b->size[a] - 1);
  }
  for (int64_t k = first[2]; k <= last[2]; ++k)
    for (int64_t j = first[1]; j <= last[1]; ++j) {
      double above = normal.y * (double)j + normal.z * (double)k - offset; /* of the plane, at i = 0 */
      int64_t i_low = first[0], i_high = last[0];
      if (fabs(normal.x) > 1e-6) {
        double one = (-above - BAND) / normal.x, other = (-above + BAND) / normal.x;
        i_low = (int64_t)most((double)i_low, ceil(least(one, other)));
        i_high = (int64_t)least((double)i_high, floor(most(one, other)));
      } else if (fabs(above) > BAND + 0.01) {
        continue;
      }
      size_t row = ((size_t)k * b->size[1] + (size_t)j) * b->size[0];
      for (int64_t i = i_low; i <= i_high; ++i) offer(b, row + (size_t)i, triangle, (vec3){(double)i, (double)j, (double)k});
    }
}

/* One slab: signs, then exact distances near the surface. */
static void start_slab(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  builder* b = context;
  int64_t low = (int64_t)index * ROWS_PER_JOB, high = low + ROWS_PER_JOB;
  if (high > b->size[2]) high = b->size[2];
  size_t first = (size_t)low * b->size[1] * b->size[0], end = (size_t)high * b->size[1] * b->size[0];
  count_crossings(b, low, high);
  /* Slabs are 8 layers thick, so no two share a byte of bits. */
  for (size_t s = first; s < end; ++s) {
    if (b->nearest[s] > 0) b->inside[s >> 3] |= (uint8_t)(1u << (s & 7));
    b->nearest[s] = NO_TRIANGLE;
    b->distance[s] = INFINITY;
  }
  for (uint32_t t = 0; t < b->triangle_count; ++t) offer_nearby(b, t, low, high);
}

/* Hands the nearest triangle of one sample on to the next, unless it had it handed on the same way a round ago. */
static void hand_on(builder* b, size_t there, size_t here, const uint32_t at[3], int pass) {
  int32_t triangle = b->nearest[there];
  if (triangle == NO_TRIANGLE || triangle == b->nearest[here] || b->changed[there] + 6 <= pass) return;
  if (offer(b, here, (uint32_t)triangle, (vec3){at[0], at[1], at[2]})) b->changed[here] = (uint8_t)pass;
}

/* All lines along b->axis in one plane, there and back. */
static void pass_plane(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  builder* b = context;
  const size_t strides[3] = {1, b->size[0], (size_t)b->size[0] * b->size[1]};
  int axis = b->axis, outer = axis == 2 ? 1 : 2, inner = 3 - axis - outer;
  /* The lines are independent; memory is gone through row by row. */
  int fast = axis == 0 ? axis : inner, slow = axis == 0 ? inner : axis;
  uint32_t at[3];
  at[outer] = index;
  for (int way = 0; way < 2; ++way)
    for (uint32_t m = axis == slow; m < b->size[slow]; ++m)
      for (uint32_t n = axis == fast; n < b->size[fast]; ++n) {
        at[slow] = axis == slow && way == 1 ? b->size[slow] - 1 - m : m;
        at[fast] = axis == fast && way == 1 ? b->size[fast] - 1 - n : n;
        size_t here = at[0] + at[1] * strides[1] + at[2] * strides[2];
        hand_on(b, way == 0 ? here - strides[axis] : here + strides[axis], here, at, b->pass + way);
      }
}

static void run_jobs(const scree_jobs* jobs, uint32_t count, void (*run)(void*, uint32_t, uint32_t), builder* b) {
  if (jobs->parallel_for != NULL) {
    jobs->parallel_for(jobs->user, count, run, b);
    return;
  }
  for (uint32_t i = 0; i < count; ++i) run(b, i, 0);
}

/* --- the grid -------------------------------------------------------------------------------------------------------------- */

/* The steepest that the interpolated distance can be in a cell: each slope lies between those of four edges. */
static float cell_slope(const float* s, size_t row, size_t plane) {
  const float *t = s + plane, *u = s + row, *v = t + row; /* the lines of this cell */
  float x = steeper(steeper(steeper(steeper(0, s[0], s[1]), t[0], t[1]), u[0], u[1]), v[0], v[1]);
  float y = steeper(steeper(steeper(steeper(0, s[0], u[0]), s[1], u[1]), t[0], v[0]), t[1], v[1]);
  float z = steeper(steeper(steeper(steeper(0, s[0], t[0]), s[1], t[1]), u[0], v[0]), u[1], v[1]);
  return sqrtf(x * x + y * y + z * z);
}

static size_t brick_at(const support_mesh* g, size_t x, size_t y, size_t z) {
  return (z * g->bricks[1] + y) * g->bricks[0] + x;
}

/* Fills brick_lipschitz and lipschitz; `own` is scratch for the bricks without their neighbours. One quantum is `quantum` steps. */
static void measure_slopes(const builder* b, support_mesh* g, float* own, float quantum) {
  const size_t row = b->size[0], plane = row * b->size[1];
  memset(own, 0, sizeof *own * g->bricks[0] * g->bricks[1] * g->bricks[2]);
  for (size_t k = 0; k + 1 < b->size[2]; ++k)
    for (size_t j = 0; j + 1 < b->size[1]; ++j)
      for (size_t i = 0; i + 1 < b->size[0]; ++i) {
        float slope = cell_slope(b->distance + k * plane + j * row + i, row, plane);
        float* brick = &own[brick_at(g, i / MESH_BRICK, j / MESH_BRICK, k / MESH_BRICK)];
        if (slope > *brick) *brick = slope;
      }
  g->lipschitz = 1; /* beside the grid */
  for (size_t z = 0; z < g->bricks[2]; ++z)
    for (size_t y = 0; y < g->bricks[1]; ++y)
      for (size_t x = 0; x < g->bricks[0]; ++x) {
        float steepest = 0;
        for (size_t c = z > 0 ? z - 1 : 0; c <= z + 1 && c < g->bricks[2]; ++c)
          for (size_t d = y > 0 ? y - 1 : 0; d <= y + 1 && d < g->bricks[1]; ++d)
            for (size_t e = x > 0 ? x - 1 : 0; e <= x + 1 && e < g->bricks[0]; ++e)
              if (own[brick_at(g, e, d, c)] > steepest) steepest = own[brick_at(g, e, d, c)];
        steepest *= quantum * 1.0001f;
        if (steepest < 1) steepest = 1;
        g->brick_lipschitz[brick_at(g, x, y, z)] = steepest;
        if (steepest > g->lipschitz) g->lipschitz = steepest;
      }
}

/* Lays the grid over the mesh's box. */
static void place_grid(support_mesh* grid, const scree_shape* shape) {
  double low[3], high[3], longest = 0;
  for (int a = 0; a < 3; ++a) {
    low[a] = high[a] = (double)shape->mesh.positions[a];
    for (uint32_t v = 1; v < shape->mesh.vertex_count; ++v) {
      double p = (double)shape->mesh.positions[(size_t)3 * v + a];
      if (p < low[a]) low[a] = p;
      if (p > high[a]) high[a] = p;
    }
    if (high[a] - low[a] > longest) longest = high[a] - low[a];
  }
  uint32_t resolution = shape->mesh.resolution > 0 ? shape->mesh.resolution : 128;
  grid->step = (float)(longest / resolution);
  grid->inverse_step = (float)(1 / (double)grid->step);
  for (int a = 0; a < 3; ++a) {
    double cells = ceil((high[a] - low[a]) / (double)grid->step - 1e-4);
    grid->size[a] = (uint32_t)cells + 1 + 2 * PADDING;
    grid->high[a] = (float)(0.5 * (grid->size[a] - 1) * (double)grid->step);
    grid->low[a] = -grid->high[a];
    grid->middle[a] = 0.5 * (low[a] + high[a]);
  }
}

static void snap_vertices(const builder* b, const support_mesh* grid, const scree_shape* shape) {
  for (uint32_t v = 0; v < shape->mesh.vertex_count; ++v)
    for (int a = 0; a < 3; ++a) {
      double from_low = (double)shape->mesh.positions[(size_t)3 * v + a] - grid->middle[a] - (double)grid->low[a];
      b->vertices[v][a] = (int32_t)floor(from_low / (double)grid->step * LATTICE + 0.5);
    }
}

static void fill_grid(builder* b, support_mesh* grid, float* brick_scratch, const scree_jobs* jobs) {
  run_jobs(jobs, (b->size[2] + ROWS_PER_JOB - 1) / ROWS_PER_JOB, start_slab, b);
  for (b->pass = 0; b->pass < 6 * ROUNDS; b->pass += 2) {
    b->axis = b->pass / 2 % 3;
    run_jobs(jobs, b->size[b->axis == 2 ? 1 : 2], pass_plane, b);
  }
  size_t count = (size_t)b->size[0] * b->size[1] * b->size[2];
  float farthest = 0;
  for (size_t s = 0; s < count; ++s)
    if (b->distance[s] > farthest) farthest = b->distance[s];
  float quantum = farthest / 32767; /* grid units; a few thousandths of a step */
  for (size_t s = 0; s < count; ++s) {
    float steps = floorf(b->distance[s] / quantum + 0.5f);
    b->distance[s] = b->inside[s >> 3] >> (s & 7) & 1 ? -steps : steps;
  }
  grid->quantum = quantum * grid->step;
  measure_slopes(b, grid, brick_scratch, quantum);

  grid->samples = (uint32_t*)b->nearest; /* its work is done */
  for (size_t s = 0; s < count; ++s) {
    bool last = s / b->size[0] % b->size[1] == b->size[1] - 1;
    uint32_t here = (uint32_t)(int32_t)b->distance[s], next = (uint32_t)(int32_t)b->distance[last ? s : s + b->size[0]];
    grid->samples[s] = (here & 0xffff) | next << 16;
  }
}

support_mesh* scree_rt_support_mesh_create(const scree_shape* shape, support_key key, const scree_jobs* jobs,
                                           const scree_allocator* allocator) {
  support_mesh* grid = scree_rt_allocate_zeroed(allocator, 1, sizeof *grid);
  if (grid == NULL) return NULL;
  grid->share.allocator = *allocator;
  grid->share.key = key;
  atomic_init(&grid->share.uses, 1);
  place_grid(grid, shape);
  size_t count = (size_t)grid->size[0] * grid->size[1] * grid->size[2], bytes = count / 8 + 1;
  builder b = {.indices = shape->mesh.indices, .triangle_count = shape->mesh.triangle_count};
  memcpy(b.size, grid->size, sizeof b.size);
  b.vertices = scree_rt_allocate(allocator, shape->mesh.vertex_count, sizeof *b.vertices);
  b.distance = scree_rt_allocate(allocator, count, sizeof *b.distance);
  b.nearest = scree_rt_allocate(allocator, count, sizeof *b.nearest);
  b.inside = scree_rt_allocate_zeroed(allocator, bytes, 1);
  b.changed = scree_rt_allocate_zeroed(allocator, count, 1);
  size_t bricks = 1;
  for (int a = 0; a < 3; ++a) {
    grid->bricks[a] = (grid->size[a] - 1 + MESH_BRICK - 1) / MESH_BRICK;
    bricks *= grid->bricks[a];
  }
  float* brick_scratch = scree_rt_allocate(allocator, bricks, sizeof *brick_scratch);
  grid->brick_lipschitz = scree_rt_allocate(allocator, bricks, sizeof *grid->brick_lipschitz);
  bool complete = b.vertices != NULL && b.distance != NULL && b.nearest != NULL && b.inside != NULL && b.changed != NULL &&
                  brick_scratch != NULL && grid->brick_lipschitz != NULL;
  if (complete) {
    snap_vertices(&b, grid, shape);
    fill_grid(&b, grid, brick_scratch, jobs);
  } else {
    scree_rt_release(allocator, b.nearest, count, sizeof *b.nearest);
  }
  scree_rt_release(allocator, brick_scratch, bricks, sizeof *brick_scratch);
  scree_rt_release(allocator, b.vertices, shape->mesh.vertex_count, sizeof *b.vertices);
  scree_rt_release(allocator, b.distance, count, sizeof *b.distance);
  scree_rt_release(allocator, b.inside, bytes, 1);
  scree_rt_release(allocator, b.changed, count, 1);
  if (complete) return grid;
  scree_rt_support_mesh_drop(grid);
  return NULL;
}

void scree_rt_support_mesh_drop(support_mesh* grid) {
  if (grid == NULL || !support_drop(&grid->share)) return;
  scree_allocator allocator = grid->share.allocator;
  scree_rt_release(&allocator, grid->samples, (size_t)grid->size[0] * grid->size[1] * grid->size[2], sizeof *grid->samples);
  scree_rt_release(&allocator, grid->brick_lipschitz, (size_t)grid->bricks[0] * grid->bricks[1] * grid->bricks[2], sizeof(float));
  scree_rt_release(&allocator, grid, 1, sizeof *grid);
}
