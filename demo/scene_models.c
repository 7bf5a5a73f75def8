#include "scene_models.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

#define LATTICE_REACH 32000 /* steps from the origin to the farthest place of all models */
#define FOOT 0.08f          /* of the height: what is lower stands on the ground */

void scene_models_destroy(scene_models* models) {
  if (models == NULL) return;
  for (uint32_t i = 0; i < models->count; ++i) painted_mesh_free(&models->models[i].mesh);
  free(models->models);
  free(models->shapes);
  free(models);
}

/* The vertices farthest along the 26 directions of a cube's faces, edges and corners, each once. */
static void measure_hull(scene_model_mesh* m) {
  const painted_mesh* mesh = &m->mesh;
  uint32_t rows[SCENE_HULL_POINTS] = {0};
  m->hull_count = 0;
  for (int code = 0; code < 27; ++code) {
    const float d[3] = {(float)(code % 3 - 1), (float)(code / 3 % 3 - 1), (float)(code / 9 - 1)};
    if (code == 13) continue;
    uint32_t best = 0;
    float farthest = -INFINITY;
    for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
      const float* p = &mesh->positions[3 * (size_t)v];
      const float reach = d[0] * p[0] + d[1] * p[1] + d[2] * p[2];
      if (reach > farthest) farthest = reach, best = v;
    }
    uint32_t known = 0;
    while (known < m->hull_count && rows[known] != best) ++known;
    if (known < m->hull_count) continue;
    rows[m->hull_count] = best;
    memcpy(&m->hull[3 * m->hull_count++], &mesh->positions[3 * (size_t)best], 3 * sizeof(float));
  }
}

/* Bounds, foot and hull. Returns the largest coordinate, 0 when nothing of the model is above the ground. */
static float measure(scene_model_mesh* m, scree_scatter_model* shape) {
  const painted_mesh* mesh = &m->mesh;
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, largest = 0;
  for (uint32_t i = 0; i < 3 * mesh->vertex_count; ++i) {
    low[i % 3] = fminf(low[i % 3], mesh->positions[i]);
    high[i % 3] = fmaxf(high[i % 3], mesh->positions[i]);
    largest = fmaxf(largest, fabsf(mesh->positions[i]));
  }
  if (!(high[1] > 0)) return 0;
  float squared = 0, foot = 0, outer = 0;
  for (int a = 0; a < 3; ++a) {
    m->centre[a] = 0.5f * (low[a] + high[a]);
    squared += (high[a] - low[a]) * (high[a] - low[a]);
  }
  m->radius = 0.5f * sqrtf(squared);
  for (uint32_t v = 0; v < mesh->vertex_count; ++v) {
    const float* p = &mesh->positions[3 * (size_t)v];
    const float across = sqrtf(p[0] * p[0] + p[2] * p[2]);
    if (p[1] < FOOT * high[1]) foot = fmaxf(foot, across);
    outer = fmaxf(outer, sqrtf(across * across + p[1] * p[1]));
  }
  measure_hull(m);
  *shape = (scree_scatter_model){
      .footprint_radius = foot > 0 ? foot : fmaxf(1e-3f * outer, 1e-6f), .height = high[1], .outer_radius = 1.0001f * outer};
  if (m->hull_count >= 4) {
    shape->hull = m->hull;
    shape->hull_count = m->hull_count;
  }
  return largest;
}

scree_result scene_models_create(const scene_model* scene, uint32_t index, const scene_paths* paths, scene_models** out,
                                 scree_error* error) {
  *out = NULL;
  const scene_scatter* scatter = &scene->fields[index].scatter;
  scene_models* made = calloc(1, sizeof *made);
  if (made == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  made->models = calloc(scatter->model_count, sizeof *made->models);
  made->shapes = calloc(scatter->model_count, sizeof *made->shapes);
  made->count = made->models != NULL ? scatter->model_count : 0;
  scree_result result = SCREE_OK;
  if (made->models == NULL || made->shapes == NULL)
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", paths->scene);
  float largest = 0;
  for (uint32_t i = 0; i < scatter->model_count && result == SCREE_OK; ++i) {
    char where[64], file[SCENE_FILE_SIZE * 2];
    scree_error cause = {""};
    scene_model_mesh* m = &made->models[i];
    snprintf(where, sizeof where, "fields[%u].models[%u]", (unsigned)index, (unsigned)i);
    result = scene_find_file(paths, where, scatter->models[i], file, sizeof file, error);
    if (result != SCREE_OK) break;
    result = painted_mesh_load(file, &m->mesh, &cause);
    if (result != SCREE_OK) {
      fail_with(error, result, "%s: %s: %.400s", paths->scene, where, cause.message);
      break;
    }
    if (m->mesh.vertex_count > SCENE_MODEL_VERTICES)
      result = fail_with(error, SCREE_ERROR_RANGE, "%s: %s: %s: %u vertices, more than the %d that are drawn", paths->scene, where,
                         file, m->mesh.vertex_count, SCENE_MODEL_VERTICES);
    const float reach = result == SCREE_OK ? measure(m, &made->shapes[i]) : 1;
    if (reach == 0)
      result =
          fail_with(error, SCREE_ERROR_RANGE, "%s: %s: %s: nothing of it is above the ground, y = 0", paths->scene, where, file);
    largest = fmaxf(largest, reach);
  }
  if (result != SCREE_OK) {
    scene_models_destroy(made);
    return result;
  }
  made->steps_per_metre = LATTICE_REACH / largest;
  *out = made;
  return SCREE_OK;
}

static uint8_t srgb_byte(float linear) {
  const float x = linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1 / 2.4f) - 0.055f;
  return (uint8_t)(x <= 0 ? 0 : x >= 1 ? 255 : 255 * x + 0.5f);
}

void scene_models_vertices(const scene_models* models, uint32_t model, scree_vertex* vertices, uint16_t* indices) {
  const painted_mesh* mesh = &models->models[model].mesh;
  for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
    const float *p = &mesh->positions[3 * (size_t)i], *n = &mesh->normals[3 * (size_t)i], *c = &mesh->colours[3 * (size_t)i];
    scree_vertex* v = &vertices[i];
    *v = (scree_vertex){.occlusion = 255};
    for (int a = 0; a < 3; ++a) {
      v->position[a] = (int16_t)lrintf(p[a] * models->steps_per_metre);
      v->normal[a] = (int16_t)lrintf(n[a] * 32767);
    }
    const uint8_t blue = srgb_byte(c[2]);
    v->material = srgb_byte(c[0]);
    v->durability = srgb_byte(c[1]);
    memcpy(&v->curvature, &blue, 1);
  }
  for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) indices[i] = (uint16_t)mesh->indices[i];
}
