#include "weather_asset.h"

#include <math.h>
#include <string.h>

#include "lod_error.h"

enum {
  MAX_LEVEL = 5,
  MAX_LATTICE = 64,
  SKIRT = 4,             /* voxels */
  MAX_EXTENT = 16384,    /* lattice steps of a side: moments of what fills such a cube still fit 64 bits */
  SEARCH_VERTICES = 4000 /* of the level that convex parts are looked for on */
};

/* As of rocks: a level that holds less or more of the finest one's volume, or that is farther off than this many of its voxels,
 * repeats the one before it. But not for a twentieth of it: crumbs and the thinnest walls may go. */
#define LEAST_VOLUME 0.8
#define MOST_VOLUME 1.2
#define MOST_ERROR 1.25f

uint32_t weather_lattice(const uint32_t size[3]) {
  uint32_t most = size[0];
  for (uint32_t axis = 1; axis < 3; ++axis)
    if (size[axis] > most) most = size[axis];
  uint32_t steps = MAX_LATTICE;
  while (steps > 1 && (uint64_t)steps * most > MAX_EXTENT) steps /= 2;
  return steps > 1 ? steps : 0;
}

static void lod_release(weather_lod* lod, const scree_allocator* allocator) {
  scree_rt_release(allocator, lod->mesh.positions, lod->mesh.vertex_count, sizeof *lod->mesh.positions);
  scree_rt_release(allocator, lod->mesh.occlusion, lod->mesh.vertex_count, 1);
  scree_rt_release(allocator, lod->mesh.surface, lod->mesh.vertex_count, sizeof *lod->mesh.surface);
  scree_rt_release(allocator, lod->mesh.indices, (size_t)lod->mesh.triangle_count * 3, sizeof *lod->mesh.indices);
  memset(lod, 0, sizeof *lod);
}

void weather_asset_destroy(weather_asset* asset, const scree_allocator* allocator) {
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  for (uint32_t k = 0; k < ROCK_MAX_LODS; ++k) lod_release(&asset->lods[k], &from);
  memset(asset, 0, sizeof *asset);
}

static scree_result lod_create(uint32_t vertices, uint32_t triangles, const scree_allocator* allocator, weather_lod* out) {
  lattice_mesh* mesh = &out->mesh;
  mesh->vertex_count = vertices;
  mesh->triangle_count = triangles;
  mesh->positions = scree_rt_allocate(allocator, vertices, sizeof *mesh->positions);
  mesh->occlusion = scree_rt_allocate(allocator, vertices, 1);
  mesh->surface = scree_rt_allocate(allocator, vertices, sizeof *mesh->surface);
  mesh->indices = scree_rt_allocate(allocator, (size_t)triangles * 3, sizeof *mesh->indices);
  const bool complete = mesh->positions != NULL && mesh->occlusion != NULL && mesh->surface != NULL && mesh->indices != NULL;
  return complete ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

/* --- A surface on the lattice. --- */

typedef struct frame {
  const uint32_t* size; /* voxels */
  uint32_t steps;       /* to a voxel */
} frame;

static int16_t to_lattice(const frame* to, uint32_t axis, float position) {
  const float origin = axis == 1 ? 0 : 0.5f * (float)to->size[axis];
  return (int16_t)floorf((position - origin) * (float)to->steps);
}

static uint8_t to_byte(float value, float least, float most) {
  return (uint8_t)((value < least ? least : value > most ? most : value) + 0.5f);
}

static bool is_flat(const int16_t a[3], const int16_t b[3], const int16_t c[3]) {
  const int32_t u[3] = {b[0] - a[0], b[1] - a[1], b[2] - a[2]}, w[3] = {c[0] - a[0], c[1] - a[1], c[2] - a[2]};
  return u[0] * w[1] == u[1] * w[0] && u[1] * w[2] == u[2] * w[1] && u[2] * w[0] == u[0] * w[2];
}

static int16_t bottom_of(const frame* on) {
  return (int16_t)(-SKIRT * (int32_t)on->steps);
}

/* Moves the floor from one height to another; nothing else is at the ground or below it. */
static bool move_floor(weather_lod* lod, int16_t from, int16_t to) {
  bool any = false;
  for (uint32_t v = 0; v < lod->mesh.vertex_count; ++v)
    if (lod->mesh.positions[v][1] == from) {
      lod->mesh.positions[v][1] = to;
      any = true;
    }
  return any;
}

/* Rounded down, so that vertices stay in their own cubes and none coincide; where that leaves a triangle without area the quad is
 * split the other way. */
static void set_mesh(const frame* to, const scree_surface* from, weather_lod* out) {
  lattice_mesh* mesh = &out->mesh;
  for (uint32_t v = 0; v < from->vertex_count; ++v) {
    const scree_surface_vertex* vertex = &from->vertices[v];
    for (uint32_t axis = 0; axis < 3; ++axis) mesh->positions[v][axis] = to_lattice(to, axis, vertex->position[axis]);
    mesh->occlusion[v] = to_byte(vertex->occlusion * 255, 0, 255);
    mesh->surface[v][0] = (uint8_t)(vertex->material | (vertex->layer < 15 ? vertex->layer : 15) << 4);
    mesh->surface[v][1] = to_byte(vertex->durability * (255.0f / 4), 0, 255);
    mesh->surface[v][2] = to_byte(128 + 127 * vertex->curvature, 1, 255);
    mesh->surface[v][3] = 0;
  }
  out->rock_triangles = from->rock_triangles;
  move_floor(out, 0, bottom_of(to));
  for (uint32_t i = 0; i < mesh->triangle_count * 3; i += 6) {
    const uint32_t* quad = from->indices + i;
    const uint32_t a = quad[0], b = quad[1], c = quad[2], d = quad[5];
    const int16_t *pa = mesh->positions[a], *pb = mesh->positions[b], *pc = mesh->positions[c], *pd = mesh->positions[d];
    const bool turn = is_flat(pa, pb, pc) || is_flat(pa, pc, pd);
    const uint32_t split[6] = {turn ? b : a, turn ? c : b, turn ? d : c, turn ? b : a, turn ? d : c, turn ? a : d};
    memcpy(mesh->indices + i, split, sizeof split);
  }
}

/* The same arrays, as what works on lattice meshes wants them. */
static mesh_buffer view_of(const weather_lod* lod) {
  mesh_buffer out = {0};
  out.positions = lod->mesh.positions;
  out.occlusion = lod->mesh.occlusion;
  out.indices = lod->mesh.indices;
  out.vertex_count = lod->mesh.vertex_count;
  out.index_count = lod->mesh.triangle_count * 3;
  return out;
}

/* --- Levels. --- */

/* Radius of the piece that each vertex belongs to, in lattice steps. pieces: scratch, one a vertex. */
static void measure_pieces(const weather_lod* lod, uint32_t* pieces, float* radii) {
  const lattice_mesh* mesh = &lod->mesh;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) pieces[v] = v;
  for (uint32_t i = 0; i < mesh->triangle_count * 3; ++i) {
    uint32_t a = mesh->indices[i], b = mesh->indices[i % 3 == 2 ? i - 2 : i + 1];
    for (; pieces[a] != a; a = pieces[a]) pieces[a] = pieces[pieces[a]];
    for (; pieces[b] != b; b = pieces[b]) pieces[b] = pieces[pieces[b]];
    if (a < b)
      pieces[b] = a;
    else
      pieces[a] = b;
  }
  /* From the piece's first vertex: never less than the true radius, and at most twice as much. */
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    while (pieces[pieces[v]] != pieces[v]) pieces[v] = pieces[pieces[v]];
    radii[v] = 0;
  }
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const int16_t *p = mesh->positions[v], *first = mesh->positions[pieces[v]];
    float distance2 = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) distance2 += (float)(p[axis] - first[axis]) * (float)(p[axis] - first[axis]);
    if (distance2 > radii[pieces[v]]) radii[pieces[v]] = distance2;
  }
  for (uint32_t v = mesh->vertex_count; v-- > 0;) radii[v] = radii[pieces[v]];
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) radii[v] = sqrtf(radii[v]);
}

/* Largest distance, in lattice steps, from a vertex of the finest level, and the one that 95 of 100 do not pass. */
static scree_result measure_error(const frame* on, const weather_lod* fine, const weather_lod* coarse,
                                  const scree_allocator* allocator, float* error, float* most) {
  const uint32_t cell = 1u << coarse->level;
  voxel_field field = {NULL, NULL, 0, 0, 0, {0}, (int32_t)(on->steps << coarse->level)};
  uint32_t size[3];
  for (uint32_t axis = 0; axis < 3; ++axis) {
    size[axis] = (on->size[axis] + cell - 1) / cell + 3;
    const int32_t middle = axis == 1 ? 0 : (int32_t)(on->size[axis] * on->steps / 2);
    field.origin[axis] = -middle - field.step * 3 / 2; /* a cube more on each side than the surface has */
  }
  const uint32_t below = (SKIRT + cell - 1) / cell; /* cubes, for the floor */
  size[1] += below;
  field.origin[1] -= field.step * (int32_t)below;
  field.width = size[0], field.height = size[1], field.depth = size[2];
  const mesh_buffer from = view_of(fine);
  mesh_buffer to = view_of(coarse);
  const size_t cubes = (size_t)size[0] * size[1] * size[2], fans = lod_error_scratch(&to);
  to.cells = scree_rt_allocate(allocator, to.vertex_count, sizeof *to.cells);
  to.vertex_of = scree_rt_allocate(allocator, cubes, sizeof *to.vertex_of);
  uint32_t* scratch = scree_rt_allocate(allocator, fans, sizeof *scratch);
  uint32_t* pieces = scree_rt_allocate(allocator, from.vertex_count, sizeof *pieces);
  float* radii = scree_rt_allocate(allocator, from.vertex_count, sizeof *radii);
  const bool complete = to.cells != NULL && to.vertex_of != NULL && scratch != NULL && pieces != NULL && radii != NULL;
  if (complete) {
    for (uint32_t v = 0; v < to.vertex_count; ++v)
      for (uint32_t axis = 0; axis < 3; ++axis) {
        const int32_t at = (to.positions[v][axis] - field.origin[axis]) / field.step;
        to.cells[v][axis] = (uint16_t)(at < 0 ? 0 : at >= (int32_t)size[axis] ? (int32_t)size[axis] - 1 : at);
      }
    measure_pieces(fine, pieces, radii);
    *error = lod_error_capped(&from, &to, &field, scratch, radii);
    *most = lod_error_of_most(&from, &to, &field, scratch, radii);
  }
  scree_rt_release(allocator, pieces, from.vertex_count, sizeof *pieces);
  scree_rt_release(allocator, radii, from.vertex_count, sizeof *radii);
  scree_rt_release(allocator, to.cells, to.vertex_count, sizeof *to.cells);
  scree_rt_release(allocator, to.vertex_of, cubes, sizeof *to.vertex_of);
  scree_rt_release(allocator, scratch, fans, sizeof *scratch);
  return complete ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

static scree_result repeat_lod(const weather_lod* from, const scree_allocator* allocator, weather_lod* out) {
  const scree_result result = lod_create(from->mesh.vertex_count, from->mesh.triangle_count, allocator, out);
  if (result != SCREE_OK) return result;
  memcpy(out->mesh.positions, from->mesh.positions, from->mesh.vertex_count * sizeof *out->mesh.positions);
  memcpy(out->mesh.occlusion, from->mesh.occlusion, from->mesh.vertex_count);
  memcpy(out->mesh.surface, from->mesh.surface, from->mesh.vertex_count * sizeof *out->mesh.surface);
  memcpy(out->mesh.indices, from->mesh.indices, (size_t)from->mesh.triangle_count * 3 * sizeof *out->mesh.indices);
  out->mesh.error = from->mesh.error;
  out->error_of_most = from->error_of_most;
  out->rock_triangles = from->rock_triangles;
  out->level = from->level;
  return SCREE_OK;
}

static scree_result make_level(scree_mesher* mesher, const frame* on, uint32_t level, const scree_allocator* allocator,
                               weather_asset* out, uint32_t lod) {
  weather_lod *here = &out->lods[lod], *before = &out->lods[lod - 1];
  scree_surface surface = {0};
  scree_result result = level <= MAX_LEVEL ? scree_mesher_update(mesher, level, &surface) : SCREE_OK;
  if (result != SCREE_OK) return result;
  if (surface.vertex_count == 0) return repeat_lod(before, allocator, here);
  result = lod_create(surface.vertex_count, surface.rock_triangles + surface.colluvium_triangles, allocator, here);
  if (result != SCREE_OK) return result;
  here->level = level;
  set_mesh(on, &surface, here);
  const mesh_buffer finest = view_of(&out->lods[0]), view = view_of(here);
  const double share = mesh_volume(&view) / mesh_volume(&finest);
  float error = 0, most = 0;
  result = measure_error(on, &out->lods[0], here, allocator, &error, &most);
  if (result != SCREE_OK) return result;
  const bool too_coarse = !(share >= LEAST_VOLUME && share <= MOST_VOLUME) || most > MOST_ERROR * (float)(on->steps << level);
  if (too_coarse) {
    lod_release(here, allocator);
    return repeat_lod(before, allocator, here);
  }
  error /= (float)on->steps;
  here->mesh.error = error > before->mesh.error ? error : before->mesh.error;
  most /= (float)on->steps;
  here->error_of_most = most > before->error_of_most ? most : before->error_of_most;
  return SCREE_OK;
}

/* --- Mass and hulls. --- */

/* Whether a point is inside: by the parity of the triangles above it. */
static bool holds(const mesh_buffer* mesh, const double p[3]) {
  bool inside = false;
  for (uint32_t i = 0; i < mesh->index_count; i += 3) {
    double c[3][3];
    for (uint32_t k = 0; k < 3; ++k)
      for (uint32_t axis = 0; axis < 3; ++axis) c[k][axis] = mesh->positions[mesh->indices[i + k]][axis] - p[axis];
    /* Does the line along y through p meet it, and above p? Its doubled areas around the line have one sign. */
    double area[3];
    bool is_left[3];
    for (uint32_t k = 0; k < 3; ++k) {
      const double *u = c[k], *w = c[(k + 1) % 3];
      /* Both neighbours of an edge compute it from the same end, so that no line slips between them. */
      const bool turned = u[0] > w[0] || (u[0] == w[0] && u[2] > w[2]);
      const double *from = turned ? w : u, *to = turned ? u : w;
      const double sum = from[0] * to[2] - from[2] * to[0];
      is_left[k] = (sum >= 0) != turned;
      area[k] = turned ? -sum : sum;
    }
    if (is_left[0] != is_left[1] || is_left[1] != is_left[2]) continue;
    const double all = area[0] + area[1] + area[2];
    if (all == 0) continue;
    const double y = (area[1] * c[0][1] + area[2] * c[1][1] + area[0] * c[2][1]) / all;
    if (y > 0) inside = !inside;
  }
  return inside;
}

/* Of meshes whose floor lies on the ground. */
static scree_result add_mass(const frame* on, const scree_allocator* allocator, weather_asset* out) {
  const mesh_buffer mesh = view_of(&out->lods[0]);
  const float voxels_per_step = 1.0f / (float)on->steps;
  rock_record record = {0};
  rock_mass(&mesh, voxels_per_step, &record);
  memcpy(out->bounds_min, record.bounds_min, sizeof out->bounds_min);
  memcpy(out->bounds_max, record.bounds_max, sizeof out->bounds_max);
  memcpy(out->centroid, record.centroid, sizeof out->centroid);
  out->volume = record.volume;
  out->outer_radius = record.outer_radius;
  const double centroid[3] = {(double)record.centroid[0] * on->steps, (double)record.centroid[1] * on->steps,
                              (double)record.centroid[2] * on->steps};
  out->inner_radius = holds(&mesh, centroid) ? record.inner_radius : 0;
  out->height = (float)out->bounds_max[1] * voxels_per_step;
  double farthest2 = 0;
  for (uint32_t v = 0; v < mesh.vertex_count; ++v) {
    const int16_t* p = mesh.positions[v];
    const double distance2 = (double)p[0] * p[0] + (double)p[2] * p[2];
    if (p[1] == 0 && distance2 > farthest2) farthest2 = distance2;
  }
  out->footprint = (float)(sqrt(farthest2) * (double)voxels_per_step * (1 + 1e-6));

  const kernel_set* kernels = kernels_choose(false);
  scree_result result = convex_hull_of(&mesh, kernels, ROCK_MAX_HULL, allocator, out->hull, &out->hull_count);
  if (result != SCREE_OK) return result;
  uint32_t search = 0;
  while (search + 1 < out->lod_count && out->lods[search].mesh.vertex_count > SEARCH_VERTICES) ++search;
  const mesh_buffer coarse = view_of(&out->lods[search]);
  result = convex_parts_of(&mesh, &coarse, kernels, allocator, out->parts, &out->part_count);
  if (result != SCREE_OK) return result;
  const double volume = mesh_volume(&mesh), hull = convex_volume((const int16_t(*)[3])out->hull, out->hull_count);
  double parts = 0;
  for (uint32_t k = 0; k < out->part_count; ++k) parts += out->parts[k].volume;
  out->hull_air = (float)(hull > volume ? 1 - volume / hull : 0);
  out->parts_air = (float)(parts > volume ? 1 - volume / parts : 0);
  return hull > 0 && out->hull_count >= 4 && out->part_count > 0 ? SCREE_OK : SCREE_ERROR_INVALID_ARGUMENT;
}

/* Bounds and outer radius hold the floor, too. */
static void add_floor(const frame* on, weather_asset* out) {
  const lattice_mesh* mesh = &out->lods[0].mesh;
  double farthest2 = 0;
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    double distance2 = 0;
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const double d = (double)mesh->positions[v][axis] / on->steps - (double)out->centroid[axis];
      distance2 += d * d;
    }
    if (distance2 > farthest2) farthest2 = distance2;
  }
  out->bounds_min[1] = bottom_of(on);
  out->outer_radius = (float)(sqrt(farthest2) * (1 + 1e-6));
}

/* --- All of it. --- */

static scree_result make_asset(scree_mesher* mesher, const frame* on, uint32_t lods, const scree_allocator* allocator,
                               weather_asset* out) {
  scree_surface surface;
  uint32_t level = 0;
  for (;; ++level) {
    if (level > MAX_LEVEL) return SCREE_ERROR_INVALID_ARGUMENT;
    const scree_result result = scree_mesher_update(mesher, level, &surface);
    if (result != SCREE_OK) return result;
    if (surface.vertex_count <= WEATHER_MAX_VERTICES) break;
  }
  if (surface.vertex_count == 0) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_result result =
      lod_create(surface.vertex_count, surface.rock_triangles + surface.colluvium_triangles, allocator, &out->lods[0]);
  if (result != SCREE_OK) return result;
  out->lods[0].level = level;
  out->lod_count = 1;
  set_mesh(on, &surface, &out->lods[0]);
  for (; out->lod_count < lods; ++out->lod_count) {
    result = make_level(mesher, on, level + out->lod_count, allocator, out, out->lod_count);
    if (result != SCREE_OK) return result;
  }
  bool stands = false;
  for (uint32_t lod = 0; lod < out->lod_count; ++lod) stands = move_floor(&out->lods[lod], bottom_of(on), 0) || stands;
  result = add_mass(on, allocator, out);
  for (uint32_t lod = 0; lod < out->lod_count; ++lod) move_floor(&out->lods[lod], 0, bottom_of(on));
  if (result == SCREE_OK && stands) add_floor(on, out);
  return result;
}

scree_result weather_asset_make(scree_mesher* mesher, const uint32_t size[3], uint32_t lattice_per_voxel, uint32_t lods,
                                const scree_allocator* allocator, weather_asset* out) {
  memset(out, 0, sizeof *out);
  const bool fits = lattice_per_voxel > 0 && lattice_per_voxel % 2 == 0 && lattice_per_voxel <= weather_lattice(size);
  if (!fits || lods < 1 || lods > ROCK_MAX_LODS) return SCREE_ERROR_INVALID_ARGUMENT;
  const scree_allocator from = scree_rt_allocator_or_default(allocator);
  const frame on = {size, lattice_per_voxel};
  out->lattice_per_voxel = lattice_per_voxel;
  const scree_result result = make_asset(mesher, &on, lods, &from, out);
  if (result != SCREE_OK) weather_asset_destroy(out, &from);
  return result;
}
