#include "stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "pack_source.h"
#include "terrain.h"
#include "timer.h"

#define PATH_SIZE (2 * SCENE_FILE_SIZE)

/* A pack and its meshes, shared by all fields that name it. */
typedef struct opened_pack {
  char path[PATH_SIZE];
  scree_pack* pack; /* NULL = free slot */
  uint32_t source;
  uint32_t users;
} opened_pack;

typedef struct staged_field {
  opened_pack* pack;
  scree_field* field;
  scree_support* support;
  scree_instance* instances;
  scree_id* ids;
  render_stone* stones;
  uint32_t count;
  double seconds;
} staged_field;

struct stage {
  stage_desc desc;
  scene_files* files;
  double origin[3];
  opened_pack packs[SCENE_FIELDS_MAX];
  staged_field fields[SCENE_FIELDS_MAX];
  uint32_t field_count;
};

/* --- Packs --- */

static scree_result open_pack(stage* s, uint32_t index, opened_pack** out, scree_error* error) {
  char where[64], path[PATH_SIZE];
  snprintf(where, sizeof where, "fields[%u].pack", (unsigned)index);
  const char* name = s->desc.scene->fields[index].pack;
  scree_result result = scene_find_pack(&s->desc.paths, where, name, path, sizeof path, error);
  if (result != SCREE_OK) return result;
  opened_pack* slot = NULL;
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) {
    opened_pack* p = &s->packs[i];
    if (p->pack != NULL && strcmp(p->path, path) == 0) {
      ++p->users;
      *out = p;
      return SCREE_OK;
    }
    if (p->pack == NULL && slot == NULL) slot = p;
  }
  if (slot == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: too many packs", path);
  scree_pack* pack = NULL;
  render_source source = {.assets = NULL};
  result = scree_pack_open_file(path, NULL, &pack);
  if (result == SCREE_OK) result = pack_source(pack, &source);
  uint32_t number = RENDER_NOTHING;
  if (result == SCREE_OK) {
    number = render_add_source(s->desc.renderer, &source);
    if (number == RENDER_NOTHING) result = SCREE_ERROR_OUT_OF_MEMORY;
  }
  free((void*)source.assets);
  if (result != SCREE_OK) {
    scree_pack_close(pack);
    return fail_with(error, result, "%s: %s", path, scree_result_string(result));
  }
  *slot = (opened_pack){.pack = pack, .source = number, .users = 1};
  memcpy(slot->path, path, sizeof path);
  *out = slot;
  return SCREE_OK;
}

static void close_pack(stage* s, opened_pack* p) {
  if (p == NULL || --p->users > 0) return;
  render_remove_source(s->desc.renderer, p->source);
  scree_pack_close(p->pack);
  *p = (opened_pack){.pack = NULL};
}

/* --- Fields --- */

static void forget_stones(staged_field* f) {
  free(f->instances);
  free(f->ids);
  free(f->stones);
  f->instances = NULL;
  f->ids = NULL;
  f->stones = NULL;
  f->count = 0;
}

static void forget_field(stage* s, staged_field* f) {
  forget_stones(f);
  scree_support_destroy(f->support);
  scree_field_destroy(f->field);
  close_pack(s, f->pack);
  *f = (staged_field){.pack = NULL};
}

static uint8_t srgb_byte(float linear) {
  float x = linear <= 0.0031308f ? 12.92f * linear : 1.055f * powf(linear, 1 / 2.4f) - 0.055f;
  return (uint8_t)(x <= 0 ? 0 : x >= 1 ? 255 : 255 * x + 0.5f);
}

static void colour_stones(const stage* s, uint32_t index, staged_field* f) {
  const scene_palette* palette = &s->desc.scene->fields[index].palette;
  for (uint32_t i = 0; i < f->count; ++i) {
    float linear[3];
    scene_stone_colour(palette, f->stones[i].hash, linear, NULL, NULL);
    for (int c = 0; c < 3; ++c) f->stones[i].colour[c] = srgb_byte(linear[c]);
  }
}

/* Queries into new arrays; the old ones go only when all is well. */
static scree_result query(const stage* s, uint32_t index, staged_field* f, scree_error* error) {
  const scene_field* model = &s->desc.scene->fields[index];
  scree_query_desc desc = {.field = f->field,
                           .support = f->support,
                           .threshold = (float)model->threshold,
                           .flags = model->shell ? SCREE_QUERY_SHELL : 0};
  memcpy(desc.origin, s->origin, sizeof desc.origin);
  uint64_t count = 0;
  scree_result result = scree_query_count(&desc, &count);
  if (result == SCREE_OK && count > STAGE_STONES_MOST)
    return fail_with(error, SCREE_ERROR_RANGE,
                     "%s: fields[%u]: %llu stones are more than the %u that can be shown; enlarge cell_size", s->desc.paths.scene,
                     (unsigned)index, (unsigned long long)count, STAGE_STONES_MOST);
  scree_instance* instances = NULL;
  scree_id* ids = NULL;
  render_stone* stones = NULL;
  if (result == SCREE_OK) {
    const size_t room = count > 0 ? (size_t)count : 1;
    instances = malloc(room * sizeof *instances);
    ids = malloc(room * sizeof *ids);
    stones = malloc(room * sizeof *stones);
    result = instances == NULL || ids == NULL || stones == NULL ? SCREE_ERROR_OUT_OF_MEMORY
                                                                : scree_query_fill(&desc, instances, ids, count, &count);
  }
  if (result != SCREE_OK) {
    free(instances);
    free(ids);
    free(stones);
    return fail_with(error, result, "%s: fields[%u]: %s", s->desc.paths.scene, (unsigned)index, scree_result_string(result));
  }
  for (uint64_t i = 0; i < count; ++i) {
    stones[i] = (render_stone){.cell_size = (float)model->cell_size,
                               .hash = scree_world_hash(f->field, &ids[i]),
                               .asset = instances[i].asset,
                               .tile = (uint8_t)scree_field_tile_code(f->field, ids[i].cube),
                               .source = (uint16_t)f->pack->source,
                               .group = (uint16_t)index};
    memcpy(stones[i].position, instances[i].position, sizeof stones[i].position);
  }
  forget_stones(f);
  f->instances = instances;
  f->ids = ids;
  f->stones = stones;
  f->count = (uint32_t)count;
  colour_stones(s, index, f);
  return SCREE_OK;
}

scree_result stage_update_field(stage* s, uint32_t index, uint32_t changed, scree_error* error) {
  staged_field* f = &s->fields[index];
  const scene_field* model = &s->desc.scene->fields[index];
  const double start = timer_seconds();
  staged_field made = *f; /* takes the place of *f when all is well */
  scree_result result = SCREE_OK;
  bool new_field = (changed & STAGE_PACK) != 0 || f->field == NULL,
       new_support = (changed & STAGE_SUPPORT) != 0 || f->support == NULL;
  if (new_field) {
    made.pack = NULL;
    made.field = NULL;
    result = open_pack(s, index, &made.pack, error);
    if (result == SCREE_OK) {
      scree_field_desc desc = {.pack = made.pack->pack, .seed = model->seed, .cell_size = model->cell_size};
      memcpy(desc.origin, model->origin, sizeof desc.origin);
      result = scree_field_create(&desc, NULL, &made.field);
      if (result != SCREE_OK)
        fail_with(error, result, "%s: fields[%u]: %s: %s", s->desc.paths.scene, (unsigned)index, made.pack->path,
                  scree_result_string(result));
    }
  }
  if (result == SCREE_OK && new_support) {
    made.support = NULL;
    result = scene_support_create(s->desc.scene, index, &s->desc.paths, s->files, &s->desc.jobs, &made.support, error);
  }
  if (result == SCREE_OK && (new_field || new_support)) {
    made.instances = NULL;
    made.ids = NULL;
    made.stones = NULL;
    result = query(s, index, &made, error);
  } else if (result == SCREE_OK) {
    colour_stones(s, index, &made);
  }
  made.seconds = timer_seconds() - start;
  if (result != SCREE_OK) {
    if (new_field) {
      scree_field_destroy(made.field);
      close_pack(s, made.pack);
    }
    if (new_support && made.support != f->support) scree_support_destroy(made.support);
    return result;
  }
  if (new_field || new_support) {
    forget_stones(f);
    if (new_support) scree_support_destroy(f->support);
    if (new_field) scree_field_destroy(f->field);
    opened_pack* before = new_field ? f->pack : NULL;
    *f = made;
    if (before != NULL) {
      /* The renderer must not hold stones of a source that goes. */
      if (before->users == 1) stage_show(s);
      close_pack(s, before);
    }
  } else {
    *f = made;
  }
  return SCREE_OK;
}

scree_result stage_update_all(stage* s, scree_error* error) {
  scree_result first = SCREE_OK;
  render_set_stones(s->desc.renderer, NULL, 0);
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) forget_field(s, &s->fields[i]);
  s->field_count = s->desc.scene->field_count;
  for (uint32_t i = 0; i < s->field_count; ++i) {
    scree_error own = {""};
    scree_result result = stage_update_field(s, i, STAGE_EVERYTHING, &own);
    if (result == SCREE_OK || first != SCREE_OK) continue;
    first = result;
    *error = own;
  }
  return first;
}

scree_result stage_show(stage* s) {
  uint64_t total = 0;
  for (uint32_t i = 0; i < s->field_count; ++i) total += s->fields[i].count;
  if (total > UINT32_MAX / 2) return SCREE_ERROR_RANGE;
  render_stone* all = malloc((total > 0 ? total : 1) * sizeof *all);
  if (all == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  uint32_t at = 0;
  for (uint32_t i = 0; i < s->field_count; ++i) {
    if (s->fields[i].count > 0) memcpy(all + at, s->fields[i].stones, s->fields[i].count * sizeof *all);
    at += s->fields[i].count;
  }
  scree_result result = render_set_stones(s->desc.renderer, all, at);
  free(all);
  return result;
}

/* --- Ground and light --- */

scree_result stage_update_ground(stage* s, scree_error* error) {
  const scene_ground* ground = &s->desc.scene->ground;
  if (ground->kind != SCENE_GROUND_TERRAIN) return render_set_terrain(s->desc.renderer, NULL, NULL, 0, NULL, 0);
  terrain_mesh mesh;
  scree_result result = terrain_mesh_create(ground, &s->desc.paths, s->files, &mesh, error);
  if (result != SCREE_OK) return result;
  for (uint32_t i = 0; i < mesh.vertex_count; ++i)
    for (int a = 0; a < 3; ++a) mesh.positions[3 * i + a] += (float)(ground->position[a] - s->origin[a]);
  result =
      render_set_terrain(s->desc.renderer, mesh.positions, mesh.normals, mesh.vertex_count, mesh.indices, 3 * mesh.triangle_count);
  terrain_mesh_free(&mesh);
  if (result != SCREE_OK) fail_with(error, result, "%s: ground: %s", s->desc.paths.scene, scree_result_string(result));
  return result;
}

void stage_light(const stage* s, render_picture* picture) {
  const scene_model* scene = s->desc.scene;
  for (int a = 0; a < 3; ++a) {
    picture->sun[a] = (float)scene->sun.direction[a];
    picture->sun_colour[a] = scene_linear_from_srgb(scene->sun.colour[a]);
    picture->sky[a] = scene_linear_from_srgb(scene->sky[a]);
    picture->ground_colour[a] = scene_linear_from_srgb(scene->ground.colour[a]);
  }
  picture->ground = scene->ground.kind == SCENE_GROUND_PLANE;
  picture->ground_height = (float)(scene->ground.height - s->origin[1]);
}

/* --- Making --- */

/* A scene near the world's origin keeps it; one that is far away, where floats grow coarse, gets its own, on whole metres. */
static void choose_origin(stage* s) {
  for (uint32_t i = 0; i < s->desc.scene->field_count; ++i) {
    const scene_node* root = s->desc.scene->fields[i].support;
    if (root == NULL) continue;
    double away = 0;
    for (int a = 0; a < 3; ++a) away = fmax(away, fabs(root->position[a]));
    if (away > 2000)
      for (int a = 0; a < 3; ++a) s->origin[a] = floor(root->position[a]);
    return;
  }
}

scree_result stage_create(const stage_desc* desc, stage** out, scree_error* error) {
  *out = NULL;
  stage* s = calloc(1, sizeof *s);
  if (s == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
  s->desc = *desc;
  s->files = scene_files_create();
  choose_origin(s);
  scree_result result =
      s->files == NULL ? fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "out of memory") : stage_update_all(s, error);
  if (result == SCREE_OK) result = stage_update_ground(s, error);
  if (result == SCREE_OK) {
    result = stage_show(s);
    if (result != SCREE_OK) fail_with(error, result, "%s: %s", desc->paths.scene, scree_result_string(result));
  }
  if (result != SCREE_OK) {
    stage_destroy(s);
    return result;
  }
  *out = s;
  return SCREE_OK;
}

void stage_destroy(stage* s) {
  if (s == NULL) return;
  render_set_stones(s->desc.renderer, NULL, 0);
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) forget_field(s, &s->fields[i]);
  scene_files_destroy(s->files);
  free(s);
}

/* --- Questions --- */

void stage_origin(const stage* s, double origin[3]) {
  memcpy(origin, s->origin, sizeof s->origin);
}

scene_files* stage_files(stage* s) {
  return s->files;
}

void stage_camera(const stage* s, const double eye[3], const double target[3], double field_of_view, camera* out) {
  float from[3], to[3];
  for (int a = 0; a < 3; ++a) {
    from[a] = (float)(eye[a] - s->origin[a]);
    to[a] = (float)(target[a] - s->origin[a]);
  }
  *out = (camera){.yaw = 0};
  camera_look(out, from, to, (float)(field_of_view * 3.14159265358979 / 180));
}

bool stage_field_bounds(const stage* s, uint32_t index, float min[3], float max[3]) {
  if (index >= s->field_count || s->fields[index].support == NULL) return false;
  double low[3], high[3];
  scree_support_bounds(s->fields[index].support, low, high);
  for (int a = 0; a < 3; ++a) {
    min[a] = (float)(low[a] - s->origin[a]);
    max[a] = (float)(high[a] - s->origin[a]);
  }
  return true;
}

bool stage_ball(const stage* s, float centre[3], float* radius) {
  float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, min[3], max[3];
  for (uint32_t i = 0; i < s->field_count; ++i) {
    if (!stage_field_bounds(s, i, min, max)) continue;
    for (int a = 0; a < 3; ++a) {
      low[a] = fminf(low[a], min[a]);
      high[a] = fmaxf(high[a], max[a]);
    }
  }
  if (!(low[0] <= high[0])) return false;
  float sum = 0;
  for (int a = 0; a < 3; ++a) {
    centre[a] = 0.5f * (low[a] + high[a]);
    sum += (high[a] - low[a]) * (high[a] - low[a]);
  }
  *radius = 0.5f * sqrtf(sum);
  return true;
}

uint32_t stage_stone_count(const stage* s, uint32_t index) {
  return index < s->field_count ? s->fields[index].count : 0;
}

double stage_update_seconds(const stage* s, uint32_t index) {
  return index < s->field_count ? s->fields[index].seconds : 0;
}
