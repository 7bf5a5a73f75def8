#include "outline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TURN 6.283185307179586
#define ROUND 48 /* segments of a circle */

void outline_clear(outline* o) {
  o->count = 0;
}

void outline_free(outline* o) {
  free(o->segments);
  memset(o, 0, sizeof *o);
}

typedef struct pen {
  outline* out;
  edit_frame frame;
  uint8_t colour[4];
} pen;

static void line(pen* p, const double from[3], const double to[3]) {
  outline* o = p->out;
  if (o->count == OUTLINE_SEGMENTS) return;
  if (o->count == o->capacity) {
    uint32_t capacity = o->capacity == 0 ? 256 : o->capacity * 2;
    render_segment* segments = realloc(o->segments, capacity * sizeof *segments);
    if (segments == NULL) return;
    o->segments = segments;
    o->capacity = capacity;
  }
  render_segment* s = &o->segments[o->count++];
  double a[3], b[3];
  edit_frame_point(&p->frame, from, a);
  edit_frame_point(&p->frame, to, b);
  for (int k = 0; k < 3; ++k) {
    s->from[k] = (float)(a[k] - o->origin[k]);
    s->to[k] = (float)(b[k] - o->origin[k]);
  }
  memcpy(s->colour, p->colour, sizeof s->colour);
}

/* Part of an ellipse: centre + u cos + v sin, from angle `from` to angle `to`, in turns. */
static void arc(pen* p, const double centre[3], const double u[3], const double v[3], double from, double to) {
  int steps = (int)ceil(ROUND * fabs(to - from));
  double before[3];
  for (int i = 0; i <= steps; ++i) {
    double angle = TURN * (from + (to - from) * i / steps), here[3];
    for (int a = 0; a < 3; ++a) here[a] = centre[a] + u[a] * cos(angle) + v[a] * sin(angle);
    if (i > 0) line(p, before, here);
    memcpy(before, here, sizeof before);
  }
}

static void draw_ellipsoid(pen* p, const double r[3]) {
  const double o[3] = {0, 0, 0}, x[3] = {r[0], 0, 0}, y[3] = {0, r[1], 0}, z[3] = {0, 0, r[2]};
  arc(p, o, x, z, 0, 1);
  arc(p, o, x, y, 0, 1);
  arc(p, o, z, y, 0, 1);
}

static void draw_box(pen* p, const double min[3], const double max[3]) {
  for (int corner = 0; corner < 8; ++corner)
    for (int axis = 0; axis < 3; ++axis) {
      if (corner >> axis & 1) continue;
      double from[3], to[3];
      for (int a = 0; a < 3; ++a) from[a] = to[a] = corner >> a & 1 ? max[a] : min[a];
      to[axis] = max[axis];
      line(p, from, to);
    }
}

static void draw_capsule(pen* p, const double a[3], const double b[3], double r) {
  double along[3], u[3], v[3], length = 0;
  for (int k = 0; k < 3; ++k) {
    along[k] = b[k] - a[k];
    length += along[k] * along[k];
  }
  length = sqrt(length);
  if (length < 1e-9) {
    memcpy(along, (double[3]){0, 1, 0}, sizeof along);
    length = 1;
  }
  for (int k = 0; k < 3; ++k) along[k] /= length;
  /* Two directions across, the first level if the axis is not upright. */
  const double hint[3] = {0, fabs(along[1]) < 0.9, fabs(along[1]) >= 0.9};
  u[0] = hint[1] * along[2] - hint[2] * along[1];
  u[1] = hint[2] * along[0] - hint[0] * along[2];
  u[2] = hint[0] * along[1] - hint[1] * along[0];
  double norm = sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  for (int k = 0; k < 3; ++k) u[k] *= r / norm;
  v[0] = along[1] * u[2] - along[2] * u[1];
  v[1] = along[2] * u[0] - along[0] * u[2];
  v[2] = along[0] * u[1] - along[1] * u[0];
  for (int k = 0; k < 3; ++k) along[k] *= r;
  const double back[3] = {-along[0], -along[1], -along[2]};
  arc(p, a, u, v, 0, 1);
  arc(p, b, u, v, 0, 1);
  arc(p, a, u, back, 0, 0.5);
  arc(p, a, v, back, 0, 0.5);
  arc(p, b, u, along, 0, 0.5);
  arc(p, b, v, along, 0, 0.5);
  for (int side = 0; side < 4; ++side) {
    const double* across = side & 1 ? v : u;
    double sign = side & 2 ? -1 : 1, from[3], to[3];
    for (int k = 0; k < 3; ++k) {
      from[k] = a[k] + sign * across[k];
      to[k] = b[k] + sign * across[k];
    }
    line(p, from, to);
  }
}

/* A cylinder, or a cone when the upper radius is 0. */
static void draw_round(pen* p, double low, double high, double low_radius, double high_radius) {
  const double bottom[3] = {0, low, 0}, top[3] = {0, high, 0};
  const double lx[3] = {low_radius, 0, 0}, lz[3] = {0, 0, low_radius}, hx[3] = {high_radius, 0, 0}, hz[3] = {0, 0, high_radius};
  arc(p, bottom, lx, lz, 0, 1);
  if (high_radius > 0) arc(p, top, hx, hz, 0, 1);
  for (int i = 0; i < 8; ++i) {
    double c = cos(TURN * i / 8), s = sin(TURN * i / 8);
    const double from[3] = {low_radius * c, low, low_radius * s}, to[3] = {high_radius * c, high, high_radius * s};
    line(p, from, to);
  }
}

static void draw_torus(pen* p, double ring, double tube) {
  for (int side = -1; side <= 1; ++side) {
    const double r = ring + side * tube, o[3] = {0, 0, 0}, x[3] = {r, 0, 0}, z[3] = {0, 0, r};
    if (side != 0 && r > 0) arc(p, o, x, z, 0, 1);
  }
  for (int i = 0; i < 8; ++i) {
    const double c = cos(TURN * i / 8), s = sin(TURN * i / 8);
    const double middle[3] = {ring * c, 0, ring * s}, out[3] = {tube * c, 0, tube * s}, up[3] = {0, tube, 0};
    arc(p, middle, out, up, 0, 1);
  }
}

static void draw_extrusion(pen* p, const scene_node* node) {
  for (uint32_t i = 0; i < node->point_count; ++i) {
    const double *a = node->points[i].place, *b = node->points[(i + 1) % node->point_count].place;
    const double low = node->extrusion.low, high = node->extrusion.high;
    const double al[3] = {a[0], low, a[2]}, ah[3] = {a[0], high, a[2]}, bl[3] = {b[0], low, b[2]}, bh[3] = {b[0], high, b[2]};
    line(p, al, bl);
    line(p, ah, bh);
    line(p, al, ah);
  }
}

/* The corners of a curve's straight pieces are the library's own business: this one goes straight through the points, with a ring,
 * or a band's cross-section, at each. */
static void draw_tube(pen* p, const scene_node* node) {
  const double high = node->tube.half_height;
  for (uint32_t i = 0; i < node->point_count; ++i) {
    const scene_point* here = &node->points[i];
    const scene_point* next = &node->points[(i + 1) % node->point_count];
    if (i + 1 < node->point_count || node->tube.closed) line(p, here->place, next->place);
    const double r = here->radius, x[3] = {r, 0, 0}, y[3] = {0, r, 0}, z[3] = {0, 0, r};
    double low[3], top[3];
    memcpy(low, here->place, sizeof low);
    memcpy(top, here->place, sizeof top);
    low[1] -= high;
    top[1] += high;
    arc(p, low, x, z, 0, 1);
    if (high > 0) {
      arc(p, top, x, z, 0, 1);
      line(p, low, top);
    } else {
      arc(p, low, x, y, 0, 1);
      arc(p, low, z, y, 0, 1);
    }
  }
}

/* Each ball's own surface: together they bulge out further. */
static void draw_blobs(pen* p, const scene_node* node) {
  for (uint32_t i = 0; i < node->point_count; ++i) {
    const double r = 0.4543 * node->points[i].radius, x[3] = {r, 0, 0}, y[3] = {0, r, 0}, z[3] = {0, 0, r};
    arc(p, node->points[i].place, x, z, 0, 1);
    arc(p, node->points[i].place, x, y, 0, 1);
    arc(p, node->points[i].place, z, y, 0, 1);
  }
}

/* A few of the endless ridges, round the origin. */
static void draw_pattern(pen* p, const scene_node* node) {
  enum { RIDGES = 8, STEPS = 64 };
  const double spacing = node->pattern.spacing, o[3] = {0, 0, 0};
  for (int i = 0; i < RIDGES; ++i) {
    if (node->pattern.kind == SCREE_PATTERN_RINGS) {
      const double r = spacing * (i + 0.5), x[3] = {r, 0, 0}, z[3] = {0, 0, r};
      arc(p, o, x, z, 0, 1);
      continue;
    }
    const bool waves = node->pattern.kind == SCREE_PATTERN_WAVES;
    const double length = RIDGES * spacing, swing = waves ? node->pattern.amplitude : 0;
    double before[3];
    for (int k = 0; k <= STEPS; ++k) {
      const double z = length * ((double)k / STEPS - 0.5);
      const double here[3] = {spacing * (i - RIDGES / 2) + swing * sin(TURN * z / node->pattern.wavelength), 0, z};
      if (k > 0) line(p, before, here);
      memcpy(before, here, sizeof before);
    }
  }
}

/* The plane of a half-space, as far as one can see round its origin. */
static void draw_plane(pen* p) {
  for (int i = -4; i <= 4; ++i) {
    const double a[3] = {i, 0, -4}, b[3] = {i, 0, 4}, c[3] = {-4, 0, i}, d[3] = {4, 0, i};
    line(p, a, b);
    line(p, c, d);
  }
}

static void draw_heights(pen* p, const scene_node* node, const scene_paths* paths, scene_files* files) {
  const height_samples* samples;
  scree_error error;
  if (files == NULL || scene_files_heights(files, paths, "outline", &node->heightfield.map, &samples, &error) != SCREE_OK) return;
  enum { LINES = 24 };
  const double spacing = node->heightfield.map.spacing;
  for (uint32_t way = 0; way < 2; ++way)
    for (uint32_t i = 0; i <= LINES; ++i) {
      double before[3];
      for (uint32_t k = 0; k <= 2 * LINES; ++k) {
        uint32_t row = i * ((way ? samples->width : samples->depth) - 1) / LINES;
        uint32_t step = k * ((way ? samples->depth : samples->width) - 1) / (2 * LINES);
        uint32_t x = way ? row : step, z = way ? step : row;
        const double here[3] = {(x - 0.5 * (samples->width - 1)) * spacing,
                                (double)samples->heights[(size_t)z * samples->width + x] + node->heightfield.above,
                                (z - 0.5 * (samples->depth - 1)) * spacing};
        if (k > 0) line(p, before, here);
        memcpy(before, here, sizeof before);
      }
    }
}

static void draw_mesh(pen* p, const scene_node* node, const scene_paths* paths, scene_files* files) {
  scree_mesh mesh;
  scree_error error;
  if (files == NULL || scene_files_mesh(files, paths, "outline", &node->mesh, &mesh, &error) != SCREE_OK) return;
  /* As many triangles as there is room for, evenly picked. */
  uint32_t stride = mesh.triangle_count / (OUTLINE_SEGMENTS / 4) + 1;
  for (uint32_t t = 0; t < mesh.triangle_count; t += stride)
    for (int k = 0; k < 3; ++k) {
      const float* a = mesh.positions + 3 * mesh.indices[3 * t + (uint32_t)k];
      const float* b = mesh.positions + 3 * mesh.indices[3 * t + (uint32_t)(k + 1) % 3];
      const double from[3] = {(double)a[0], (double)a[1], (double)a[2]}, to[3] = {(double)b[0], (double)b[1], (double)b[2]};
      line(p, from, to);
    }
}

static void draw_node(pen* p, const scene_node* root, const scene_node* node, const scene_paths* paths, scene_files* files) {
  for (uint32_t i = 0; i < node->child_count; ++i) draw_node(p, root, node->children[i], paths, files);
  if (!edit_node_frame(root, node, &p->frame, NULL)) return;
  double min[3], max[3];
  switch (node->kind) {
    case SCREE_SHAPE_SPHERE: {
      const double r = node->sphere.radius, radii[3] = {r, r, r};
      draw_ellipsoid(p, radii);
      break;
    }
    case SCREE_SHAPE_BOX:
      edit_leaf_box(node, min, max);
      draw_box(p, min, max);
      break;
    case SCREE_SHAPE_CAPSULE: draw_capsule(p, node->capsule.a, node->capsule.b, node->capsule.radius); break;
    case SCREE_SHAPE_CYLINDER:
      draw_round(p, -node->cylinder.half_height, node->cylinder.half_height, node->cylinder.radius, node->cylinder.radius);
      break;
    case SCREE_SHAPE_CONE: draw_round(p, 0, node->cone.height, node->cone.radius, 0); break;
    case SCREE_SHAPE_HEIGHTFIELD: draw_heights(p, node, paths, files); break;
    case SCREE_SHAPE_ELLIPSOID: draw_ellipsoid(p, node->ellipsoid.radii); break;
    case SCREE_SHAPE_HALF_SPACE: draw_plane(p); break;
    case SCREE_SHAPE_TORUS: draw_torus(p, node->torus.radius, node->torus.tube_radius); break;
    case SCREE_SHAPE_EXTRUSION: draw_extrusion(p, node); break;
    case SCREE_SHAPE_TUBE: draw_tube(p, node); break;
    case SCREE_SHAPE_BLOBS: draw_blobs(p, node); break;
    case SCREE_SHAPE_PATTERN: draw_pattern(p, node); break;
    case SCREE_SHAPE_MESH: draw_mesh(p, node, paths, files); break;
    default: break;
  }
}

void outline_add_node(outline* o, const scene_node* root, const scene_node* node, const scene_paths* paths, scene_files* files,
                      const uint8_t colour[4]) {
  pen p = {.out = o};
  memcpy(p.colour, colour, sizeof p.colour);
  draw_node(&p, root, node, paths, files);
}

void outline_add_arrows(outline* o, const double place[3], double length, int hot) {
  static const uint8_t colours[3][4] = {{222, 66, 58, 255}, {92, 178, 62, 255}, {66, 116, 232, 255}};
  static const uint8_t highlight[4] = {255, 236, 120, 255};
  pen p = {.out = o, .frame = {.rotation = {0, 0, 0, 1}, .scale = length}};
  memcpy(p.frame.translation, place, sizeof p.frame.translation);
  for (int axis = 0; axis < 3; ++axis) {
    memcpy(p.colour, axis == hot ? highlight : colours[axis], sizeof p.colour);
    const double from[3] = {0, 0, 0}, to[3] = {axis == 0, axis == 1, axis == 2};
    line(&p, from, to);
    for (int side = 0; side < 4; ++side) {
      double barb[3];
      for (int a = 0; a < 3; ++a) barb[a] = 0.84 * to[a];
      barb[(axis + 1 + side % 2) % 3] += side & 2 ? 0.06 : -0.06;
      line(&p, to, barb);
    }
  }
}
