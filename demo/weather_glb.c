#include "weather_glb.h"

#include <math.h>
#include <stdlib.h>

#include "file.h"
#include "glb.h"
#include "weather_colour.h"

typedef struct vertex_streams {
  float *positions, *normals;
  uint8_t* colours;
  float min[3], max[3];
} vertex_streams;

static bool fill(vertex_streams* s, const scree_surface* surface, const uint32_t size[3], double voxel) {
  const size_t count = surface->vertex_count;
  s->positions = malloc(count * 3 * sizeof *s->positions);
  s->normals = malloc(count * 3 * sizeof *s->normals);
  s->colours = malloc(count * 4);
  if (s->positions == NULL || s->normals == NULL || s->colours == NULL) return false;
  for (int a = 0; a < 3; ++a) {
    s->min[a] = INFINITY;
    s->max[a] = -INFINITY;
  }
  for (size_t i = 0; i < count; ++i) {
    const scree_surface_vertex* v = &surface->vertices[i];
    float tint[3];
    weather_natural_tint(v, tint);
    for (int a = 0; a < 3; ++a) {
      const double middle = a == 1 ? 0 : 0.5 * size[a];
      const float at = (float)(((double)v->position[a] - middle) * voxel);
      s->positions[3 * i + a] = at;
      s->normals[3 * i + a] = v->normal[a];
      s->colours[4 * i + a] = (uint8_t)(tint[a] * 255 + 0.5f);
      s->min[a] = fminf(s->min[a], at);
      s->max[a] = fmaxf(s->max[a], at);
    }
    s->colours[4 * i + 3] = 255;
  }
  return true;
}

scree_result weather_glb_write(const char* path, const char* name, const scree_surface* surface, const uint32_t size[3],
                               double voxel, scree_error* error) {
  if (surface->vertex_count == 0) return fail_with(error, SCREE_ERROR_RANGE, "%.200s: nothing is left to be written", path);
  vertex_streams s = {0};
  glb_writer* file = NULL;
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (fill(&s, surface, size, voxel))
    result = glb_begin(path, &file, error);
  else
    fail_with(error, result, "%.200s: out of memory", path);
  if (result == SCREE_OK) {
    glb_mesh colluvium = {.positions = glb_add_data(file, GLB_POSITIONS, s.positions, surface->vertex_count, s.min, s.max),
                          .normals = glb_add_data(file, GLB_NORMALS, s.normals, surface->vertex_count, NULL, NULL),
                          .colours = glb_add_data(file, GLB_COLOURS, s.colours, surface->vertex_count, NULL, NULL),
                          .uvs = GLB_NONE,
                          .blob = GLB_NONE};
    glb_mesh rock = colluvium;
    const uint32_t* rest = surface->indices + (size_t)3 * surface->rock_triangles;
    const bool has_rock = surface->rock_triangles > 0, has_colluvium = surface->colluvium_triangles > 0;
    if (has_rock) {
      rock.indices = glb_add_data(file, GLB_INDICES32, surface->indices, 3 * surface->rock_triangles, NULL, NULL);
      rock.material = glb_add_material(file, "rock", weather_rock_base);
    }
    if (has_colluvium) {
      colluvium.indices = glb_add_data(file, GLB_INDICES32, rest, 3 * surface->colluvium_triangles, NULL, NULL);
      colluvium.material = glb_add_material(file, "colluvium", weather_colluvium_base);
    }
    rock.also = has_colluvium ? &colluvium : NULL;
    glb_mesh* whole = has_rock ? &rock : &colluvium;
    whole->name = name;
    const glb_node node = {.name = name,
                           .mesh = glb_add_mesh(file, whole),
                           .translations = GLB_NONE,
                           .instance_colours = GLB_NONE,
                           .rotations = GLB_NONE,
                           .scales = GLB_NONE,
                           .is_root = true};
    glb_add_node(file, &node);
    result = glb_finish(file, NULL, error);
  }
  free(s.positions);
  free(s.normals);
  free(s.colours);
  return result;
}
