#include "stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "pack_source.h"
#include "terrain.h"
#include "timer.h"

typedef struct staged_field {
  scene_rocks rocks;
  render_stone* stones; /* rocks.count, room for rocks.capacity */
  uint64_t stones_room;
  uint32_t count;
  double seconds;
} staged_field;

struct stage {
  stage_desc desc;
  scene_live* world;
  double origin[3];
  uint32_t sources[SCENE_FIELDS_MAX + 1]; /* of the renderer, by the world's slots of packs */
  staged_field fields[SCENE_FIELDS_MAX];
  uint32_t field_count;
};

/* --- Packs --- */

static scree_result pack_opened(void* user, uint32_t slot, const scree_pack* pack, const scene_models* models) {
  stage* s = user;
  render_source source = {.assets = NULL};
  scree_result result = models != NULL ? models_source(models, &source) : pack_source(pack, &source);
  if (result != SCREE_OK) return result;
  s->sources[slot] = render_add_source(s->desc.renderer, &source);
  free((void*)source.assets);
  return s->sources[slot] == RENDER_NOTHING ? SCREE_ERROR_OUT_OF_MEMORY : SCREE_OK;
}

static void pack_closing(void* user, uint32_t slot) {
  stage* s = user;
  /* The renderer must not hold stones of a source that goes: it gets the others back with the next stage_show. */
  render_set_stones(s->desc.renderer, NULL, 0);
  render_remove_source(s->desc.renderer, s->sources[slot]);
}

/* --- Fields --- */

static void forget_field(staged_field* f) {
  scene_rocks_free(&f->rocks);
  free(f->stones);
  *f = (staged_field){.stones = NULL};
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

static scree_result query(stage* s, uint32_t index, scree_error* error) {
  staged_field* f = &s->fields[index];
  const scene_field* model = &s->desc.scene->fields[index];
  f->count = 0;
  scree_result result = scene_live_query(s->world, index, s->origin, s->desc.flags, STAGE_STONES_MOST, &f->rocks, error);
  if (result != SCREE_OK) return result;
  if (f->rocks.count > f->stones_room) {
    render_stone* stones = malloc((size_t)f->rocks.capacity * sizeof *stones);
    if (stones == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->desc.paths.scene);
    free(f->stones);
    f->stones = stones;
    f->stones_room = f->rocks.capacity;
  }
  const scree_scene* scene = scene_live_scene(s->world);
  const scree_field* field = scene_live_field(s->world, index);
  const scree_scatter* scatter = scene_live_scatter(s->world, index);
  const uint16_t source = (uint16_t)s->sources[scene_live_pack_slot(s->world, index)];
  for (uint64_t i = 0; i < f->rocks.count; ++i) {
    const scree_rock* rock = &f->rocks.rocks[i];
    render_stone* stone = &f->stones[i];
    *stone = (render_stone){.cell_size = (float)model->cell_size,
                            .hash = scree_scene_random(scene, &rock->id),
                            .asset = rock->asset,
                            .source = source,
                            .group = (uint16_t)index};
    if (scatter != NULL) {
      scree_scatter_turn(scatter, stone->hash, stone->turn, &stone->cell_size);
      stone->hash = scene_model_hash(stone->hash);
    } else {
      stone->tile = (uint8_t)scree_field_tile_code(field, rock->id.cube);
    }
    memcpy(stone->position, rock->position, sizeof stone->position);
  }
  f->count = (uint32_t)f->rocks.count;
  colour_stones(s, index, f);
  return SCREE_OK;
}

/* Where a field can have rocks; false when it is not open. */
static bool field_box(const stage* s, uint32_t index, double min[3], double max[3]) {
  const scree_support* support = scene_live_support(s->world, index);
  if (support == NULL) return false;
  scree_support_bounds(support, min, max);
  for (int a = 0; a < 3; ++a) {
    min[a] -= scene_live_reach(s->world, index);
    max[a] += scene_live_reach(s->world, index);
  }
  return true;
}

static bool boxes_meet(const double a_min[3], const double a_max[3], const double b_min[3], const double b_max[3]) {
  for (int a = 0; a < 3; ++a)
    if (a_min[a] > b_max[a] || b_min[a] > a_max[a]) return false;
  return true;
}

/* Where the rocks of a field were and are. */
typedef struct field_boxes {
  double min[2][3], max[2][3];
  uint32_t count;
} field_boxes;

static void add_box(const stage* s, uint32_t index, field_boxes* boxes) {
  if (field_box(s, index, boxes->min[boxes->count], boxes->max[boxes->count])) ++boxes->count;
}

/* Has an earlier field changed where this one is? */
static bool meets_earlier(const field_boxes* boxes, uint32_t index) {
  for (uint32_t i = 0; i < index; ++i)
    for (uint32_t a = 0; a < boxes[i].count; ++a)
      for (uint32_t b = 0; b < boxes[index].count; ++b)
        if (boxes_meet(boxes[i].min[a], boxes[i].max[a], boxes[index].min[b], boxes[index].max[b])) return true;
  return false;
}

static void keep_first(scree_result result, const scree_error* own, scree_result* first, scree_error* error) {
  if (result == SCREE_OK || *first != SCREE_OK) return;
  *first = result;
  *error = *own;
}

scree_result stage_update_fields(stage* s, const uint32_t changed[SCENE_FIELDS_MAX], scree_error* error) {
  field_boxes boxes[SCENE_FIELDS_MAX]; /* of the fields that are queried */
  uint64_t stale = 0;
  scree_result first = SCREE_OK;
  for (uint32_t i = 0; i < s->field_count; ++i) {
    staged_field* f = &s->fields[i];
    boxes[i].count = 0;
    if (changed[i] == 0) continue;
    const double start = timer_seconds();
    scree_error own = {""};
    add_box(s, i, &boxes[i]);
    const scree_result result = scene_live_update(s->world, i, changed[i], &own);
    keep_first(result, &own, &first, error);
    if (result != SCREE_OK || (changed[i] & ~(uint32_t)SCENE_CHANGED_PALETTE) == 0) {
      boxes[i].count = 0;
      if (result == SCREE_OK) colour_stones(s, i, f);
    } else {
      if ((changed[i] & SCENE_CHANGED_PACK) != 0) f->count = 0; /* their pack may be gone */
      stale |= UINT64_C(1) << i;
    }
    f->seconds = timer_seconds() - start;
  }
  for (uint32_t i = 0; i < s->field_count; ++i) {
    const bool updated = (stale >> i & 1) != 0;
    add_box(s, i, &boxes[i]);
    if (!updated && !meets_earlier(boxes, i)) {
      boxes[i].count = 0;
      continue;
    }
    if (!updated) s->fields[i].seconds = 0;
    const double start = timer_seconds();
    scree_error own = {""};
    if (scene_live_layer(s->world, i) != UINT32_MAX) keep_first(query(s, i, &own), &own, &first, error);
    s->fields[i].seconds += timer_seconds() - start;
  }
  return first;
}

scree_result stage_update_all(stage* s, scree_error* error) {
  render_set_stones(s->desc.renderer, NULL, 0);
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) forget_field(&s->fields[i]);
  s->field_count = s->desc.scene->field_count;
  scree_result first = scene_live_update_all(s->world, error);
  for (uint32_t i = 0; i < s->field_count; ++i) {
    if (scene_live_layer(s->world, i) == UINT32_MAX) continue;
    const double start = timer_seconds();
    scree_error own = {""};
    scree_result result = query(s, i, &own);
    s->fields[i].seconds = timer_seconds() - start;
    keep_first(result, &own, &first, error);
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
  scree_result result = terrain_mesh_create(ground, &s->desc.paths, scene_live_files(s->world), &mesh, error);
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
  picture->ground_sand = scene->ground.sand;
  picture->water = scene->ground.kind == SCENE_GROUND_TERRAIN && scene->ground.water;
  picture->ground = scene->ground.kind == SCENE_GROUND_PLANE || picture->water;
  picture->ground_height = (float)((picture->water ? scene->ground.water_height : scene->ground.height) - s->origin[1]);
  for (int a = 0; a < 3; ++a) picture->water_colour[a] = scene_linear_from_srgb(scene->ground.water_colour[a]);
}

/* --- Making --- */

/* A scene near the world's origin keeps it; one that is far away, where floats grow coarse, gets its own, on whole metres. */
static void choose_origin(stage* s) {
  for (uint32_t i = 0; i < s->desc.scene->field_count; ++i) {
    const scene_field* field = &s->desc.scene->fields[i];
    if (field->support == NULL && !field->is_cliff) continue;
    const double* position = field->is_cliff ? field->origin : field->support->position;
    double away = 0;
    for (int a = 0; a < 3; ++a) away = fmax(away, fabs(position[a]));
    if (away > 2000)
      for (int a = 0; a < 3; ++a) s->origin[a] = floor(position[a]);
    return;
  }
}

scree_result stage_create(const stage_desc* desc, stage** out, scree_error* error) {
  *out = NULL;
  stage* s = calloc(1, sizeof *s);
  if (s == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
  s->desc = *desc;
  choose_origin(s);
  const scene_live_desc wanted = {.scene = desc->scene,
                                  .paths = desc->paths,
                                  .jobs = desc->jobs,
                                  .pack_opened = pack_opened,
                                  .pack_closing = pack_closing,
                                  .user = s};
  scree_result result = scene_live_create(&wanted, &s->world, error);
  if (result == SCREE_OK) result = stage_update_all(s, error);
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
  for (uint32_t i = 0; i < SCENE_FIELDS_MAX; ++i) forget_field(&s->fields[i]);
  scene_live_destroy(s->world);
  free(s);
}

/* --- Questions --- */

void stage_origin(const stage* s, double origin[3]) {
  memcpy(origin, s->origin, sizeof s->origin);
}

uint32_t stage_times(const stage* s, uint32_t field) {
  const scree_pack* pack =
      field < s->desc.scene->field_count && s->desc.scene->fields[field].is_cliff ? scene_live_pack(s->world, field) : NULL;
  scree_pack_info info = {.time_count = 0};
  if (pack != NULL) scree_pack_get_info(pack, &info);
  return info.time_count;
}

uint32_t stage_mesh_times(const stage* s, const scene_node* node) {
  return node->kind == SCREE_SHAPE_MESH ? scene_files_times(scene_live_files(s->world), &s->desc.paths, &node->mesh) : 0;
}

scene_files* stage_files(stage* s) {
  return scene_live_files(s->world);
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
  const scree_support* support = scene_live_support(s->world, index);
  if (support == NULL) return false;
  double low[3], high[3];
  scree_support_bounds(support, low, high);
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
