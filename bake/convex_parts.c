#include "convex_parts.h"

#include <string.h>

#include "lattice.h"

/* --- Volume of the hull of a few points. --- */

typedef struct hull_face {
  uint8_t corner[3]; /* counter-clockwise from outside */
  bool gone;
} hull_face;

enum { MOST_FACES = 4 * ROCK_MAX_HULL };

static double above(const double (*p)[3], const hull_face* f, const double q[3]) {
  const double *a = p[f->corner[0]], *b = p[f->corner[1]], *c = p[f->corner[2]];
  const double u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, v[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  const double w[3] = {q[0] - a[0], q[1] - a[1], q[2] - a[2]};
  return w[0] * (u[1] * v[2] - u[2] * v[1]) + w[1] * (u[2] * v[0] - u[0] * v[2]) + w[2] * (u[0] * v[1] - u[1] * v[0]);
}

/* Six times the volume, by adding points one at a time. The points are moved by less than 1/500 of a lattice step first, so that no
 * four lie in a plane. */
double convex_volume(const int16_t (*points)[3], uint32_t count) {
  double p[ROCK_MAX_HULL][3];
  hull_face faces[MOST_FACES];
  uint32_t face_count = 0;
  for (uint32_t i = 0; i < count; ++i)
    for (uint32_t axis = 0; axis < 3; ++axis)
      p[i][axis] = points[i][axis] + (double)(hash_mix(i * 3 + axis + 1) >> 44) * 0x1p-29 - 0x1p-10;
  if (count < 4) return 0;
  for (uint32_t k = 0; k < 4; ++k) {
    hull_face f = {{(uint8_t)(k == 0 ? 1 : 0), (uint8_t)(k <= 1 ? 2 : 1), (uint8_t)(k <= 2 ? 3 : 2)}, false};
    if (above((const double(*)[3])p, &f, p[k]) > 0) {
      const uint8_t swapped = f.corner[1];
      f.corner[1] = f.corner[2];
      f.corner[2] = swapped;
    }
    faces[face_count++] = f;
  }
  for (uint32_t i = 4; i < count; ++i) {
    /* The edges between faces that see the point and faces that do not, each as the seeing face has it. */
    uint8_t edges[MOST_FACES][2];
    uint32_t edge_count = 0;
    for (uint32_t f = 0; f < face_count; ++f) faces[f].gone = above((const double(*)[3])p, &faces[f], p[i]) > 0;
    for (uint32_t f = 0; f < face_count; ++f)
      for (uint32_t k = 0; faces[f].gone && k < 3; ++k) {
        const uint8_t from = faces[f].corner[k], to = faces[f].corner[(k + 1) % 3];
        bool inner = false;
        for (uint32_t g = 0; g < face_count && !inner; ++g)
          for (uint32_t m = 0; faces[g].gone && m < 3; ++m)
            inner = inner || (faces[g].corner[m] == to && faces[g].corner[(m + 1) % 3] == from);
        if (!inner && edge_count < MOST_FACES) edges[edge_count][0] = from, edges[edge_count++][1] = to;
      }
    uint32_t kept = 0;
    for (uint32_t f = 0; f < face_count; ++f)
      if (!faces[f].gone) faces[kept++] = faces[f];
    face_count = kept;
    for (uint32_t e = 0; e < edge_count && face_count < MOST_FACES; ++e)
      faces[face_count++] = (hull_face){{edges[e][0], edges[e][1], (uint8_t)i}, false};
  }
  double volume6 = 0;
  for (uint32_t f = 0; f < face_count; ++f) volume6 += above((const double(*)[3])p, &faces[f], p[0]);
  return volume6 < 0 ? -volume6 / 6 : 0;
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

static uint32_t hull_of_points(part_points* points, const kernel_set* kernels, uint32_t most, int16_t (*hull)[3]) {
  if (points->count == 0) return 0;
  const float* const at[3] = {points->at[0], points->at[1], points->at[2]};
  uint32_t chosen[ROCK_MAX_HULL];
  const uint32_t count = farthest_points(kernels, at, pad(points), most, chosen);
  for (uint32_t k = 0; k < count; ++k)
    for (uint32_t axis = 0; axis < 3; ++axis) hull[k][axis] = nearest_step(points->at[axis][chosen[k]]);
  return count;
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
    *count = hull_of_points(&points, kernels, most, hull);
  }
  points_destroy(&points, allocator);
  return complete ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

/* --- Where to cut. --- */

/* Places along an axis that are tried, and the least share of the mesh's volume that a cut has to save. */
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
  const uint32_t count = hull_of_points(tree->points, tree->kernels, PARTS_MAX_HULL, hull);
  return convex_volume((const int16_t(*)[3])hull, count);
}

typedef struct tree_part {
  box within;
  double volume;
  double best[2]; /* volumes of the halves of its best cut */
  uint32_t axis;
  float plane;
} tree_part;

static void find_cut(const part_tree* tree, tree_part* part) {
  part->best[0] = part->volume;
  part->best[1] = 0;
  part->axis = 3;
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t k = 1; k <= TRIES; ++k) {
      const float low = part->within.min[axis], high = part->within.max[axis];
      const float plane = low + (high - low) * ((float)k / (TRIES + 1));
      box below = part->within, over = part->within;
      below.max[axis] = over.min[axis] = plane;
      const double a = hull_volume(tree, &below), b = hull_volume(tree, &over);
      if (a == 0 || b == 0 || a + b >= part->best[0] + part->best[1]) continue;
      part->best[0] = a;
      part->best[1] = b;
      part->axis = axis;
      part->plane = plane;
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
  const double least = LEAST_SAVED * mesh_volume(coarse);
  tree_part found[PARTS_MAX];
  uint32_t found_count = 1;
  found[0].within = bounds_of(coarse);
  found[0].volume = hull_volume(&tree, &found[0].within);
  find_cut(&tree, &found[0]);
  while (found_count < PARTS_MAX) {
    uint32_t best = 0;
    double saved = 0;
    for (uint32_t k = 0; k < found_count; ++k) {
      const double here = found[k].volume - found[k].best[0] - found[k].best[1];
      if (found[k].axis < 3 && here > saved) saved = here, best = k;
    }
    if (saved <= least) break;
    tree_part *below = &found[best], *over = &found[found_count++];
    *over = *below;
    below->within.max[below->axis] = over->within.min[below->axis] = below->plane;
    over->volume = below->best[1];
    below->volume = below->best[0];
    find_cut(&tree, over);
    find_cut(&tree, below);
  }
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
    part->hull_count = hull_of_points(&points, kernels, PARTS_MAX_HULL, part->hull);
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
