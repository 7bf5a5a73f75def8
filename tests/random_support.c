#include "random_support.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A wavy ball: 1-Lipschitz because the wave's slope is below 0.3 and the whole is divided by 1.3. */
static void wavy_ball(void* user, const float* x, const float* y, const float* z, float* distance, uint32_t count) {
  const float* wave = user;
  for (uint32_t i = 0; i < count; ++i) {
    float r = sqrtf(x[i] * x[i] + y[i] * y[i] + z[i] * z[i]), t = x[i] * wave[1];
    float saw = fabsf(t - floorf(t) - 0.5f) * 0.3f / wave[1]; /* a triangle wave of slope 0.3 */
    distance[i] = (r - wave[0] + saw) / 1.3f;
  }
}

void random_rotation(random_stream* r, float q[4]) {
  double v[4], length2;
  do {
    length2 = 0;
    for (int a = 0; a < 4; ++a) {
      v[a] = random_in(r, -1, 1);
      length2 += v[a] * v[a];
    }
  } while (length2 > 1 || length2 < 0.01);
  for (int a = 0; a < 4; ++a) q[a] = (float)(v[a] / sqrt(length2));
}

static void random_transform(random_stream* r, scree_transform* t, double reach) {
  memset(t, 0, sizeof *t);
  for (int a = 0; a < 3; ++a) t->translation[a] = (float)random_in(r, -reach, reach);
  if (random_below(r, 3) > 0) random_rotation(r, t->rotation);
  if (random_below(r, 2) > 0) t->scale = (float)random_in(r, 0.6, 1.6);
}

/* A ring of four square posts: 16 vertices, 32 triangles. */
static void square_ring(float* positions, uint32_t* indices, random_stream* r, double size) {
  double outer = size, inner = size * random_in(r, 0.3, 0.7), half = size * random_in(r, 0.2, 0.5);
  for (uint32_t i = 0; i < 4; ++i)
    for (uint32_t k = 0; k < 4; ++k) { /* k: outer bottom, outer top, inner top, inner bottom */
      double radius = k < 2 ? outer : inner, y = k == 1 || k == 2 ? half : -half;
      float* p = &positions[3 * (4 * i + k)];
      p[0] = (float)(radius * (i == 0 || i == 3 ? 1 : -1));
      p[1] = (float)y;
      p[2] = (float)(radius * (i < 2 ? 1 : -1));
    }
  uint32_t* t = indices;
  for (uint32_t i = 0; i < 4; ++i)
    for (uint32_t k = 0; k < 4; ++k) {
      uint32_t a = 4 * i + k, b = 4 * i + (k + 1) % 4, c = 4 * ((i + 1) % 4) + (k + 1) % 4, d = 4 * ((i + 1) % 4) + k;
      const uint32_t quad[6] = {a, b, c, a, c, d};
      memcpy(t, quad, sizeof quad);
      t += 6;
    }
}

/* A star with arms of random length, which may cross themselves. */
static void fill_extrusion(float* points, random_stream* r, scree_shape* shape, double size) {
  uint32_t count = 3 + random_below(r, 12);
  for (uint32_t i = 0; i < count; ++i) {
    double turn = 6.28318530718 * (i + random_in(r, -0.7, 0.7)) / count, arm = size * random_in(r, 0.3, 1.2);
    points[2 * i] = (float)(arm * cos(turn));
    points[2 * i + 1] = (float)(arm * sin(turn));
  }
  shape->extrusion.points = points;
  shape->extrusion.point_count = count;
  shape->extrusion.low = (float)(-size * random_in(r, 0.1, 0.8));
  shape->extrusion.high = (float)(size * random_in(r, 0, 0.8));
}

static void fill_tube(float* points, float* radii, random_stream* r, scree_shape* shape, double size) {
  shape->tube.point_count = 2 + random_below(r, 5);
  bool band = random_below(r, 2);
  for (uint32_t i = 0; i < shape->tube.point_count; ++i) {
    for (uint32_t a = 0; a < 3; ++a) points[3 * i + a] = (float)(size * random_in(r, -1, 1) * (band && a == 1 ? 0.3 : 1));
    radii[i] = (float)(size * random_in(r, 0.05, 0.3));
  }
  shape->tube.points = points;
  shape->tube.radii = radii;
  shape->tube.closed = random_below(r, 2);
  shape->tube.subdivisions = random_below(r, 7);
  shape->tube.half_height = band ? (float)(size * random_in(r, 0.1, 0.5)) : 0;
}

static void fill_leaf(random_leaf_data* data, random_stream* r, scree_shape* shape, scree_shape_kind kind, double reach) {
  memset(shape, 0, sizeof *shape);
  shape->kind = kind;
  random_transform(r, &shape->transform, reach * 0.5);
  double size = reach * random_in(r, 0.15, 0.5);
  switch (kind) {
    case SCREE_SHAPE_SPHERE: shape->sphere.radius = (float)size; break;
    case SCREE_SHAPE_BOX: {
      float least = (float)size;
      for (int a = 0; a < 3; ++a) {
        shape->box.half[a] = (float)(size * random_in(r, 0.3, 1.2));
        if (shape->box.half[a] < least) least = shape->box.half[a];
      }
      shape->box.rounding = random_below(r, 2) ? (float)random_in(r, 0, 1) * least : 0;
      break;
    }
    case SCREE_SHAPE_CAPSULE:
      for (int a = 0; a < 3; ++a) {
        shape->capsule.a[a] = (float)random_in(r, -size, size);
        shape->capsule.b[a] = random_below(r, 8) ? (float)random_in(r, -size, size) : shape->capsule.a[a];
      }
      shape->capsule.radius = (float)(size * random_in(r, 0.2, 0.7));
      break;
    case SCREE_SHAPE_CYLINDER:
      shape->cylinder.radius = (float)(size * random_in(r, 0.3, 1));
      shape->cylinder.half_height = (float)(size * random_in(r, 0.2, 1));
      break;
    case SCREE_SHAPE_CONE:
      shape->cone.radius = (float)(size * random_in(r, 0.3, 1));
      shape->cone.height = (float)(size * random_in(r, 0.4, 2));
      break;
    case SCREE_SHAPE_HEIGHTFIELD: {
      uint32_t width = 2 + random_below(r, 22), depth = 2 + random_below(r, 22);
      double spacing = 2 * size / (width > depth ? width : depth), steep = random_in(r, 0.1, 1);
      for (uint32_t i = 0; i < width * depth; ++i) data->heights[i] = (float)(random_in(r, 0, 1) * spacing * steep);
      shape->heightfield.heights = data->heights;
      shape->heightfield.width = width;
      shape->heightfield.depth = depth;
      shape->heightfield.spacing = (float)spacing;
      shape->heightfield.above = (float)(size * random_in(r, -0.1, 0.3));
      shape->heightfield.below = (float)(size * random_in(r, 0.2, 0.5));
      break;
    }
    case SCREE_SHAPE_MESH:
      square_ring(data->mesh_positions, data->mesh_indices, r, size);
      shape->mesh.positions = data->mesh_positions;
      shape->mesh.indices = data->mesh_indices;
      shape->mesh.vertex_count = 16;
      shape->mesh.triangle_count = 32;
      shape->mesh.resolution = 8 + random_below(r, 25);
      break;
    case SCREE_SHAPE_ELLIPSOID:
      for (int a = 0; a < 3; ++a) shape->ellipsoid.radii[a] = (float)(size * random_in(r, 0.2, 1.2));
      if (random_below(r, 4) == 0) shape->ellipsoid.radii[1] = shape->ellipsoid.radii[2]; /* round one way */
      break;
    case SCREE_SHAPE_HALF_SPACE: break;
    case SCREE_SHAPE_TORUS:
      shape->torus.radius = (float)(size * random_in(r, 0.4, 1));
      shape->torus.tube_radius = (float)(size * random_in(r, 0.1, 0.5));
      break;
    case SCREE_SHAPE_EXTRUSION: fill_extrusion(data->points, r, shape, size); break;
    case SCREE_SHAPE_TUBE: fill_tube(data->points, data->radii, r, shape, size); break;
    case SCREE_SHAPE_BLOBS:
      shape->blobs.count = 1 + random_below(r, 8);
      shape->blobs.centres = data->points;
      shape->blobs.radii = data->radii;
      for (uint32_t i = 0; i < shape->blobs.count; ++i) {
        for (uint32_t a = 0; a < 3; ++a) data->points[3 * i + a] = (float)random_in(r, -size, size);
        data->radii[i] = (float)(size * random_in(r, 0.5, 1.5));
      }
      break;
    case SCREE_SHAPE_PATTERN:
      shape->pattern.kind = (scree_pattern_kind)random_below(r, 3);
      shape->pattern.spacing = (float)(size * random_in(r, 0.3, 1));
      shape->pattern.radius = shape->pattern.spacing * (float)random_in(r, 0.1, 0.6);
      shape->pattern.wavelength = (float)(size * random_in(r, 0.5, 2));
      shape->pattern.amplitude = random_below(r, 5) ? shape->pattern.wavelength * (float)random_in(r, 0.02, 0.3) : 0;
      break;
    default:
      shape->kind = SCREE_SHAPE_CALLBACK;
      data->wave[0] = (float)size;
      data->wave[1] = (float)random_in(r, 0.2, 1);
      shape->callback.distance = wavy_ball;
      shape->callback.user = data->wave;
      for (int a = 0; a < 3; ++a) {
        shape->callback.min[a] = (float)(-size * 1.0001);
        shape->callback.max[a] = (float)(size * 1.0001);
      }
      break;
  }
}

static scree_shape_kind any_kind(random_stream* r, bool with_mesh) {
  scree_shape_kind kind = (scree_shape_kind)random_below(r, SCREE_SHAPE_PATTERN + 1);
  return kind == SCREE_SHAPE_MESH && !with_mesh ? SCREE_SHAPE_BOX : kind;
}

void random_leaf(random_support* s, random_stream* r, scree_shape_kind kind, double reach) {
  memset(&s->desc, 0, sizeof s->desc);
  fill_leaf(&s->data[0], r, &s->shapes[0], kind < SCREE_SHAPE_UNION ? kind : any_kind(r, true), reach);
  s->desc.shapes = s->shapes;
  s->desc.shape_count = 1;
}

/* A tree in the making: shapes are made from the last to the first, leaves, then groups over shapes that have no parent yet. */
typedef struct grower {
  scree_shape* shapes;
  uint32_t* children;
  uint32_t next, used; /* the last shape made; children taken */
} grower;

static scree_shape* grow(grower* g, scree_shape_kind kind) {
  scree_shape* shape = &g->shapes[--g->next];
  memset(shape, 0, sizeof *shape);
  shape->kind = kind;
  return shape;
}

/* The shape that was made last, cut by a box. */
static void cut(grower* g, double half) {
  uint32_t* children = &g->children[g->used];
  children[0] = g->next;
  scree_shape* box = grow(g, SCREE_SHAPE_BOX);
  for (int a = 0; a < 3; ++a) box->box.half[a] = (float)half;
  children[1] = g->next;
  scree_shape* group = grow(g, SCREE_SHAPE_INTERSECTION);
  group->group.children = children;
  group->group.child_count = 2;
  g->used += 2;
}

static scree_shape_kind any_group(random_stream* r) {
  static const scree_shape_kind groups[] = {SCREE_SHAPE_UNION,      SCREE_SHAPE_UNION,        SCREE_SHAPE_INTERSECTION,
                                            SCREE_SHAPE_DIFFERENCE, SCREE_SHAPE_SMOOTH_UNION, SCREE_SHAPE_SMOOTH_UNION};
  return groups[random_below(r, 6)];
}

static bool is_endless(scree_shape_kind kind) {
  return kind == SCREE_SHAPE_HALF_SPACE || kind == SCREE_SHAPE_PATTERN;
}

/* Displaces the shape that was made last. */
static void displace(grower* g, random_stream* r, double reach) {
  uint32_t child = g->next;
  scree_shape* noise = grow(g, SCREE_SHAPE_NOISE);
  random_transform(r, &noise->transform, reach * 0.1);
  noise->noise = (scree_noise){.child = child,
                               .amplitude = (float)(reach * random_in(r, 0.01, 0.1)),
                               .wavelength = (float)(reach * random_in(r, 0.1, 0.8)),
                               .octaves = random_below(r, 5),
                               .seed = random_below(r, 1000)};
}

/* Groups of two to four orphans until one is left. */
static void join(grower* g, random_stream* r, uint32_t* orphans, uint32_t orphan_count, double reach) {
  while (orphan_count > 1) {
    uint32_t take = 2 + random_below(r, 3);
    if (take > orphan_count) take = orphan_count;
    scree_shape* group = grow(g, any_group(r));
    random_transform(r, &group->transform, reach * 0.1);
    group->group.children = &g->children[g->used];
    group->group.child_count = take;
    group->group.blend = (float)(reach * random_in(r, 0.02, 0.4));
    for (uint32_t k = 0; k < take; ++k) {
      uint32_t pick = random_below(r, orphan_count);
      g->children[g->used++] = orphans[pick];
      orphans[pick] = orphans[--orphan_count];
    }
    if (random_below(r, 4) == 0) displace(g, r, reach);
    orphans[orphan_count++] = g->next;
  }
}

/* The array starts at shape `next`: children count from there. */
static void count_from_first(const grower* g, uint32_t end) {
  for (uint32_t i = 0; i < g->used; ++i) g->children[i] -= g->next;
  for (uint32_t i = g->next; i < end; ++i)
    if (g->shapes[i].kind == SCREE_SHAPE_NOISE) g->shapes[i].noise.child -= g->next;
}

void random_tree(random_support* s, random_stream* r, uint32_t leaves, double reach) {
  memset(&s->desc, 0, sizeof s->desc);
  grower g = {s->shapes, s->children, RANDOM_MAX_SHAPES, 0};
  uint32_t orphans[RANDOM_MAX_LEAVES];
  bool endless = false;
  for (uint32_t i = 0; i < leaves; ++i) {
    scree_shape_kind kind = any_kind(r, true);
    fill_leaf(&s->data[i], r, &s->shapes[--g.next], kind, reach);
    bool uncut = is_endless(kind) && random_below(r, 3) == 0;
    if (is_endless(kind) && !uncut) cut(&g, reach * random_in(r, 0.3, 1));
    endless = endless || uncut;
    orphans[i] = g.next;
  }
  join(&g, r, orphans, leaves, reach);
  if (endless) cut(&g, reach * 1.5);
  count_from_first(&g, RANDOM_MAX_SHAPES);
  s->desc.shapes = &s->shapes[g.next];
  s->desc.shape_count = RANDOM_MAX_SHAPES - g.next;
}

enum { CLUSTER_LEAVES = 7, CLUSTER_SHAPES = 5 * CLUSTER_LEAVES };

random_grove random_grove_create(random_stream* r, uint32_t clusters, double reach, double spread) {
  const uint32_t room = clusters * CLUSTER_SHAPES + 1;
  random_grove grove = {.shapes = malloc(room * sizeof(scree_shape)),
                        .children = malloc(2 * room * sizeof(uint32_t)),
                        .data = malloc(clusters * CLUSTER_LEAVES * sizeof(random_leaf_data))};
  uint32_t* roots = malloc(clusters * sizeof *roots);
  if (grove.shapes == NULL || grove.children == NULL || grove.data == NULL || roots == NULL) abort();
  grower g = {grove.shapes, grove.children, room, 0};
  for (uint32_t c = 0; c < clusters; ++c) {
    uint32_t orphans[CLUSTER_LEAVES];
    for (uint32_t i = 0; i < CLUSTER_LEAVES; ++i) { /* every kind has its turn */
      uint32_t index = c * CLUSTER_LEAVES + i;
      scree_shape_kind kind = (scree_shape_kind)(index % (SCREE_SHAPE_PATTERN + 1));
      fill_leaf(&grove.data[index], r, &grove.shapes[--g.next], kind, reach);
      if (is_endless(kind)) cut(&g, reach * random_in(r, 0.3, 0.7));
      orphans[i] = g.next;
    }
    join(&g, r, orphans, CLUSTER_LEAVES, reach);
    for (int a = 0; a < 3; ++a)
      grove.shapes[g.next].transform.translation[a] += (float)(random_in(r, -spread, spread) * (a == 1 ? 0.25 : 1));
    roots[c] = g.next;
  }
  scree_shape* root = grow(&g, SCREE_SHAPE_UNION);
  root->group.children = &g.children[g.used];
  root->group.child_count = clusters;
  for (uint32_t c = 0; c < clusters; ++c) g.children[g.used++] = roots[c];
  count_from_first(&g, room);
  free(roots);
  grove.desc = (scree_support_desc){.shapes = &grove.shapes[g.next], .shape_count = room - g.next};
  return grove;
}

void random_grove_destroy(random_grove* grove) {
  free(grove->shapes);
  free(grove->children);
  free(grove->data);
  memset(grove, 0, sizeof *grove);
}
