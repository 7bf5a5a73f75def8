#include "convex_parts.h"

#include <math.h>
#include <string.h>

#include "lattice.h"
#include "vectors.h"

/* --- The hull of a few points. --- */

enum {
  MOST_FACES = 2 * ROCK_MAX_HULL,
  DIRECTIONS = 290 /* along (x, y, z), whole numbers from -3 to 3 without a common factor */
};

typedef struct hull_face {
  uint8_t corner[3]; /* counter-clockwise from outside */
  bool gone;
} hull_face;

typedef struct small_hull {
  double p[ROCK_MAX_HULL][3];
  uint32_t count;
  hull_face faces[MOST_FACES];
  uint32_t face_count;
} small_hull;

static void normal_of(const double a[3], const double b[3], const double c[3], double out[3]) {
  const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  out[0] = u[1] * v[2] - u[2] * v[1];
  out[1] = u[2] * v[0] - u[0] * v[2];
  out[2] = u[0] * v[1] - u[1] * v[0];
}

/* Six times the volume between a face and a point, > 0 outside. */
static double above(const small_hull* hull, const hull_face* f, const double q[3]) {
  const double* a = hull->p[f->corner[0]];
  double n[3];
  normal_of(a, hull->p[f->corner[1]], hull->p[f->corner[2]], n);
  return dot(n, (const double[3]){q[0] - a[0], q[1] - a[1], q[2] - a[2]});
}

/* Moves a point by less than 1/500 of a lattice step, so that no four lie in a plane. */
static void loosen(const double point[3], uint32_t name, double out[3]) {
  for (uint32_t axis = 0; axis < 3; ++axis)
    out[axis] = point[axis] + (double)(hash_mix(name * 3 + axis + 1) >> 44) * 0x1p-29 - 0x1p-10;
}

/* p: four points, loosened. */
static void hull_start(small_hull* hull, const double p[4][3]) {
  memcpy(hull->p, p, 4 * sizeof *p);
  hull->count = hull->face_count = 4;
  for (uint32_t k = 0; k < 4; ++k) {
    hull_face f = {{(uint8_t)(k == 0 ? 1 : 0), (uint8_t)(k <= 1 ? 2 : 1), (uint8_t)(k <= 2 ? 3 : 2)}, false};
    if (above(hull, &f, p[k]) > 0) {
      const uint8_t swapped = f.corner[1];
      f.corner[1] = f.corner[2];
      f.corner[2] = swapped;
    }
    hull->faces[k] = f;
  }
}

/* The faces that see the point give way to ones from their rim to it. */
static void hull_add(small_hull* hull, const double point[3]) {
  uint8_t rim[MOST_FACES][2];
  uint32_t rim_count = 0, kept = 0;
  for (uint32_t f = 0; f < hull->face_count; ++f) hull->faces[f].gone = above(hull, &hull->faces[f], point) > 0;
  for (uint32_t f = 0; f < hull->face_count; ++f)
    for (uint32_t k = 0; hull->faces[f].gone && k < 3; ++k) {
      const uint8_t from = hull->faces[f].corner[k], to = hull->faces[f].corner[(k + 1) % 3];
      bool inner = false;
      for (uint32_t g = 0; g < hull->face_count && !inner; ++g)
        for (uint32_t m = 0; hull->faces[g].gone && m < 3; ++m)
          inner = inner || (hull->faces[g].corner[m] == to && hull->faces[g].corner[(m + 1) % 3] == from);
      if (!inner && rim_count < MOST_FACES) rim[rim_count][0] = from, rim[rim_count++][1] = to;
    }
  if (rim_count == 0) return;
  for (uint32_t f = 0; f < hull->face_count; ++f)
    if (!hull->faces[f].gone) hull->faces[kept++] = hull->faces[f];
  hull->face_count = kept;
  memcpy(hull->p[hull->count], point, sizeof hull->p[0]);
  for (uint32_t e = 0; e < rim_count && hull->face_count < MOST_FACES; ++e)
    hull->faces[hull->face_count++] = (hull_face){{rim[e][0], rim[e][1], (uint8_t)hull->count}, false};
  ++hull->count;
}

double convex_volume(const int16_t (*points)[3], uint32_t count) {
  small_hull hull;
  double p[ROCK_MAX_HULL][3], volume6 = 0;
  for (uint32_t i = 0; i < count; ++i) loosen((const double[3]){points[i][0], points[i][1], points[i][2]}, i, p[i]);
  if (count < 4) return 0;
  hull_start(&hull, (const double(*)[3])p);
  for (uint32_t i = 4; i < count; ++i) hull_add(&hull, p[i]);
  for (uint32_t f = 0; f < hull.face_count; ++f) volume6 -= above(&hull, &hull.faces[f], p[0]);
  return volume6 > 0 ? volume6 / 6 : 0;
}

/* How far a point lies outside, < 0 inside. */
static double outside(const small_hull* hull, const double q[3]) {
  double most = -INFINITY;
  for (uint32_t f = 0; f < hull->face_count; ++f) {
    const double *a = hull->p[hull->faces[f].corner[0]], *b = hull->p[hull->faces[f].corner[1]],
                 *c = hull->p[hull->faces[f].corner[2]];
    double n[3];
    normal_of(a, b, c, n);
    const double length = sqrt(dot(n, n));
    const double height = dot(n, (const double[3]){q[0] - a[0], q[1] - a[1], q[2] - a[2]});
    if (length > 0 && height > most * length) most = height / length;
  }
  return most;
}

/* Of candidates, `most` or fewer that span nearly their whole hull: the first four as far apart as can be, then always the one that
 * is farthest outside of the hull so far. chosen: their numbers. */
static uint32_t pick_corners(const double (*candidates)[3], uint32_t count, uint32_t most, uint32_t* chosen) {
  enum { WHOLE = 4 };
  if (count < WHOLE) return 0;
  double p[WHOLE][3];
  chosen[0] = 0;
  for (uint32_t k = 1; k < WHOLE; ++k) {
    double farthest = -1;
    for (uint32_t i = 0; i < count; ++i) {
      const double* q = candidates[i];
      const double u[3] = {q[0] - p[0][0], q[1] - p[0][1], q[2] - p[0][2]};
      double measure = dot(u, u), n[3];
      if (k == 1 && i == 0) memcpy(p[0], q, sizeof p[0]), measure = 0;
      if (k > 1) {
        normal_of(p[0], p[1], k == 2 ? q : p[2], n);
        const double height = dot(n, u);
        measure = k == 2 ? dot(n, n) : height * height;
      }
      if (measure > farthest) farthest = measure, chosen[k] = i;
    }
    memcpy(p[k], candidates[chosen[k]], sizeof p[k]);
  }
  small_hull hull;
  hull_start(&hull, (const double(*)[3])p);
  uint32_t picked = WHOLE;
  while (picked < most) {
    double farthest = 0.5; /* what is nearer than half a step is as good as inside */
    uint32_t best = count;
    for (uint32_t i = 0; i < count; ++i) {
      const double off = outside(&hull, candidates[i]);
      if (off > farthest) farthest = off, best = i;
    }
    if (best == count) break;
    hull_add(&hull, candidates[best]);
    chosen[picked++] = best;
  }
  return picked;
}

/* --- What of a mesh lies in a box. --- */

typedef struct box {
  float min[3], max[3];
} box;

typedef struct part_points {
  float* at[3];
  uint32_t count, capacity;
} part_points;

/* A triangle cut by six planes has up to nine corners. */
enum { MOST_CORNERS = 9, CUT_POINTS = 3 * MOST_CORNERS };

static uint32_t cut(const float (*in)[3], uint32_t count, uint32_t axis, float plane, bool keep_below, float (*out)[3]) {
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const float *a = in[i], *b = in[(i + 1) % count];
    const bool a_in = keep_below ? a[axis] <= plane : a[axis] >= plane, b_in = keep_below ? b[axis] <= plane : b[axis] >= plane;
    if (a_in) memcpy(out[kept++], a, sizeof *out);
    if (a_in != b_in) {
      const float t = (plane - a[axis]) / (b[axis] - a[axis]);
      for (uint32_t k = 0; k < 3; ++k) out[kept][k] = a[k] + (b[k] - a[k]) * t;
      out[kept++][axis] = plane;
    }
  }
  return kept;
}

static void add_point(part_points* points, const float p[3]) {
  for (uint32_t axis = 0; axis < 3; ++axis) points->at[axis][points->count] = p[axis];
  ++points->count;
}

/* The vertices in a box, and where its faces cut triangles. */
static void collect(const mesh_buffer* mesh, const box* within, part_points* out) {
  out->count = 0;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    float p[3];
    bool in = true;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      p[axis] = mesh->positions[v][axis];
      in = in && p[axis] >= within->min[axis] && p[axis] <= within->max[axis];
    }
    if (in) add_point(out, p);
  }
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    float polygon[2][MOST_CORNERS + 1][3];
    bool whole = true, apart = false;
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t axis = 0; axis < 3; ++axis) polygon[0][k][axis] = mesh->positions[mesh->indices[i + k]][axis];
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const float a = polygon[0][0][axis], b = polygon[0][1][axis], c = polygon[0][2][axis];
      const float low = a < b ? (a < c ? a : c) : (b < c ? b : c), high = a > b ? (a > c ? a : c) : (b > c ? b : c);
      whole = whole && low >= within->min[axis] && high <= within->max[axis];
      apart = apart || high < within->min[axis] || low > within->max[axis];
    }
    if (whole || apart) continue;
    uint32_t count = 3, from = 0;
    for (uint32_t face = 0; face < 6 && count > 0; ++face, from ^= 1)
      count = cut((const float(*)[3])polygon[from], count, face / 2, face & 1 ? within->max[face / 2] : within->min[face / 2],
                  (face & 1) != 0, polygon[from ^ 1]);
    for (uint32_t k = 0; k < count && out->count + LANES < out->capacity; ++k) add_point(out, polygon[from][k]);
  }
}

/* --- Hulls. --- */

/* The last lanes are filled with the first point. */
static uint32_t pad(part_points* points) {
  const uint32_t padded = round_to_lanes(points->count);
  for (uint32_t k = points->count; k < padded; ++k)
    for (uint32_t axis = 0; axis < 3; ++axis) points->at[axis][k] = points->at[axis][0];
  return padded;
}

static int16_t nearest_step(float v) {
  return (int16_t)(v < 0 ? v - 0.5f : v + 0.5f);
}

/* The hull's corners in a few fixed directions: quick, for what is tried and thrown away. */
static uint32_t rough_hull(part_points* points, const kernel_set* kernels, int16_t (*hull)[3]) {
  if (points->count == 0) return 0;
  const float* const at[3] = {points->at[0], points->at[1], points->at[2]};
  uint32_t chosen[PARTS_MAX_HULL];
  const uint32_t count = farthest_points(kernels, at, pad(points), PARTS_MAX_HULL, chosen);
  for (uint32_t k = 0; k < count; ++k)
    for (uint32_t axis = 0; axis < 3; ++axis) hull[k][axis] = nearest_step(points->at[axis][chosen[k]]);
  return count;
}

static uint32_t fine_hull(part_points* points, const kernel_set* kernels, uint32_t most, int16_t (*hull)[3]) {
  if (points->count == 0) return 0;
  const float* const at[3] = {points->at[0], points->at[1], points->at[2]};
  const uint32_t padded = pad(points);
  int16_t corners[DIRECTIONS][3];
  double candidates[DIRECTIONS][3];
  uint32_t count = 0, chosen[ROCK_MAX_HULL];
  for (int32_t code = 0; code < 343; ++code) {
    const int32_t d[3] = {code % 7 - 3, code / 7 % 7 - 3, code / 49 - 3};
    const bool halves = d[0] % 2 == 0 && d[1] % 2 == 0 && d[2] % 2 == 0, thirds = d[0] % 3 == 0 && d[1] % 3 == 0 && d[2] % 3 == 0;
    if (halves || thirds) continue;
    const uint32_t best = kernels->farthest(at, padded, (const float[3]){(float)d[0], (float)d[1], (float)d[2]});
    for (uint32_t axis = 0; axis < 3; ++axis) corners[count][axis] = nearest_step(points->at[axis][best]);
    bool known = false;
    for (uint32_t k = 0; k < count; ++k) known = known || memcmp(corners[k], corners[count], sizeof *corners) == 0;
    if (known) continue;
    loosen((const double[3]){corners[count][0], corners[count][1], corners[count][2]}, count, candidates[count]);
    ++count;
  }
  const uint32_t picked = pick_corners((const double(*)[3])candidates, count, most, chosen);
  for (uint32_t k = 0; k < picked; ++k) memcpy(hull[k], corners[chosen[k]], sizeof *hull);
  return picked;
}

/* Room for the points of any part of a mesh: cut triangles are few, and those that do not fit are left out. */
static bool points_create(const mesh_buffer* mesh, const scree_allocator* allocator, part_points* out) {
  *out = (part_points){{NULL, NULL, NULL}, 0, round_to_lanes(mesh->vertex_count * 2 + 64 * CUT_POINTS)};
  bool complete = true;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    out->at[axis] = scree_rt_allocate(allocator, out->capacity, sizeof(float));
    complete = complete && out->at[axis] != NULL;
  }
  return complete;
}

static void points_destroy(part_points* points, const scree_allocator* allocator) {
  for (uint32_t axis = 0; axis < 3; ++axis) scree_rt_release(allocator, points->at[axis], points->capacity, sizeof(float));
}

static box bounds_of(const mesh_buffer* mesh) {
  box out = {{32767, 32767, 32767}, {-32768, -32768, -32768}};
  for (uint32_t v = 0; v < mesh->vertex_count; ++v)
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const float p = mesh->positions[v][axis];
      if (p < out.min[axis]) out.min[axis] = p;
      if (p > out.max[axis]) out.max[axis] = p;
    }
  return out;
}

scree_result convex_hull_of(const mesh_buffer* mesh, const kernel_set* kernels, uint32_t most, const scree_allocator* allocator,
                            int16_t (*hull)[3], uint32_t* count) {
  part_points points;
  const bool complete = points_create(mesh, allocator, &points);
  if (complete) {
    const box all = bounds_of(mesh);
    collect(mesh, &all, &points);
    *count = fine_hull(&points, kernels, most, hull);
  }
  points_destroy(&points, allocator);
  return complete ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

/* --- Where to cut. --- */

/* Places along an axis that are tried, and the share of the mesh's volume that a cut has to save to be worth another part. */
enum { TRIES = 15 };
#define LEAST_SAVED 0.025

typedef struct part_tree {
  const mesh_buffer* mesh;
  const kernel_set* kernels;
  part_points* points;
} part_tree;

static double hull_volume(const part_tree* tree, const box* within) {
  int16_t hull[PARTS_MAX_HULL][3];
  collect(tree->mesh, within, tree->points);
  const uint32_t count = rough_hull(tree->points, tree->kernels, hull);
  return convex_volume((const int16_t(*)[3])hull, count);
}

typedef struct tree_part {
  box within;
  double volume;
  double best[2]; /* volumes of the halves of its best cut */
  uint32_t axis;
  float plane;
} tree_part;

/* Tries a cut; keeps it if it is the best so far. */
static void try_cut(const part_tree* tree, tree_part* part, uint32_t axis, float plane) {
  box below = part->within, over = part->within;
  below.max[axis] = over.min[axis] = plane;
  const double a = hull_volume(tree, &below), b = hull_volume(tree, &over);
  if (a == 0 || b == 0 || a + b >= part->best[0] + part->best[1]) return;
  part->best[0] = a;
  part->best[1] = b;
  part->axis = axis;
  part->plane = plane;
}

/* The best cut; where none saves its price, one through the middle: two may part what one does not, a ring for instance. */
static void find_cut(const part_tree* tree, double price, tree_part* part) {
  const float *min = part->within.min, *max = part->within.max;
  part->best[0] = INFINITY;
  part->best[1] = 0;
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t k = 1; k <= TRIES; ++k) try_cut(tree, part, axis, min[axis] + (max[axis] - min[axis]) * ((float)k / (TRIES + 1)));
  if (part->volume - part->best[0] - part->best[1] > price) return;
  const uint32_t xz = max[2] - min[2] > max[0] - min[0] ? 2 : 0, longest = max[1] - min[1] > max[xz] - min[xz] ? 1 : xz;
  const tree_part before = *part;
  part->best[0] = INFINITY;
  part->best[1] = 0;
  try_cut(tree, part, longest, 0.5f * (min[longest] + max[longest]));
  if (part->best[0] == INFINITY) *part = before;
}

/* Cuts greedily until there are PARTS_MAX, even where a cut alone saves nothing: two may part what one does not, a ring for
 * instance. Of all numbers of parts on the way the one is taken that is worth its price. */
static uint32_t find_parts(const part_tree* tree, tree_part found[PARTS_MAX]) {
  const double solid = mesh_volume(tree->mesh), price = LEAST_SAVED * solid;
  tree_part parts[PARTS_MAX];
  parts[0].within = bounds_of(tree->mesh);
  parts[0].volume = hull_volume(tree, &parts[0].within);
  double total = parts[0].volume, cheapest = INFINITY;
  uint32_t best_count = 1;
  for (uint32_t count = 1;; ++count) {
    if (total + price * count < cheapest) {
      cheapest = total + price * count;
      best_count = count;
      memcpy(found, parts, count * sizeof *parts);
    }
    if (count == PARTS_MAX || cheapest <= solid + price * (count + 1)) return best_count;
    if (count == 1) find_cut(tree, price, &parts[0]);
    uint32_t cut = 0;
    double most = -INFINITY;
    for (uint32_t k = 0; k < count; ++k) {
      const double saved = parts[k].volume - parts[k].best[0] - parts[k].best[1];
      if (saved > most) most = saved, cut = k;
    }
    if (most == -INFINITY) return best_count;
    tree_part *below = &parts[cut], *over = &parts[count];
    *over = *below;
    below->within.max[below->axis] = over->within.min[below->axis] = below->plane;
    over->volume = below->best[1];
    below->volume = below->best[0];
    total -= most;
    find_cut(tree, price, over);
    find_cut(tree, price, below);
  }
}

/* By height; equal ones keep their order. */
static void sort_parts(convex_part* parts, uint32_t count) {
  for (uint32_t i = 1; i < count; ++i)
    for (uint32_t k = i; k > 0 && parts[k - 1].bottom > parts[k].bottom; --k) {
      const convex_part swapped = parts[k];
      parts[k] = parts[k - 1];
      parts[k - 1] = swapped;
    }
}

scree_result convex_parts_of(const mesh_buffer* mesh, const mesh_buffer* coarse, const kernel_set* kernels,
                             const scree_allocator* allocator, convex_part* parts, uint32_t* count) {
  part_points coarse_points = {0}, points = {0};
  if (!points_create(coarse, allocator, &coarse_points) || !points_create(mesh, allocator, &points)) {
    points_destroy(&coarse_points, allocator);
    points_destroy(&points, allocator);
    return SCREE_ERROR_OUT_OF_MEMORY;
  }
  const part_tree tree = {coarse, kernels, &coarse_points};
  tree_part found[PARTS_MAX];
  const uint32_t found_count = find_parts(&tree, found);
  /* The coarse shape's outer faces are not quite those of the mesh. */
  const box outer = bounds_of(coarse), all = bounds_of(mesh);
  *count = 0;
  for (uint32_t k = 0; k < found_count; ++k) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      if (found[k].within.min[axis] == outer.min[axis]) found[k].within.min[axis] = all.min[axis];
      if (found[k].within.max[axis] == outer.max[axis]) found[k].within.max[axis] = all.max[axis];
    }
    convex_part* part = &parts[*count];
    collect(mesh, &found[k].within, &points);
    part->hull_count = fine_hull(&points, kernels, PARTS_MAX_HULL, part->hull);
    part->volume = convex_volume((const int16_t(*)[3])part->hull, part->hull_count);
    if (part->hull_count < 4 || part->volume == 0) continue;
    part->bottom = part->hull[0][1];
    for (uint32_t v = 1; v < part->hull_count; ++v)
      if (part->hull[v][1] < part->bottom) part->bottom = part->hull[v][1];
    ++*count;
  }
  sort_parts(parts, *count);
  points_destroy(&coarse_points, allocator);
  points_destroy(&points, allocator);
  return SCREE_OK;
}
