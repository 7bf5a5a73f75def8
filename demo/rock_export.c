/* Rocks as a .glb file: which meshes and nodes, and what is in them. */
#include "rock_export.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "glb.h"
#include "glb_draco.h"

enum {
  FLAT_SHADES = 4, /* materials per base colour where rocks have no colour of their own */
  BATCH = 256      /* meshes that are made between two writes */
};

/* Primitives of a mesh. All but cliffs are whole rock. */
enum { ROCK = 0, CUT = 1, PARTS = 2 };

struct rock_export {
  rock_export_desc desc;
  glb_writer* glb;
  char* path;
  rock_export_stats stats;
};

/* Rocks are sorted by this: all of one shape stand together, and within them all of one material. */
typedef struct rock {
  uint32_t asset, material;
  uint32_t row; /* in the layer */
  float shade;
} rock;

/* A primitive; empty where its counts are 0. */
typedef struct part {
  uint32_t vertex_count, triangle_count;
  scree_vertex* vertices;
  uint8_t* colours; /* 4 a vertex, linear */
  float* uvs;       /* 2 a vertex, or NULL */
  uint32_t* indices;
  glb_draco draco;
} part;

/* One shape on its way from the pack to the file. */
typedef struct shape {
  uint32_t asset;
  part parts[PARTS];
  scree_result result;
} shape;

typedef struct layer_state {
  rock_export* out;
  const rock_layer* layer;
  uint32_t lod;
  bool hoodoos;               /* vertices know their beds */
  bool cliff;                 /* vertices know cuts */
  float uv_min[2], uv_max[2]; /* equal where there are no UVs */
  float step;                 /* metres per lattice step */
  uint32_t materials[PARTS][SCENE_PALETTE_MAX * FLAT_SHADES];
  rock* rocks;
  shape* shapes; /* BATCH */
  uint32_t first_node;
  uint32_t nodes;
  rock_export_stats stats;
} layer_state;

scree_result rock_export_begin(const rock_export_desc* desc, rock_export** out, scree_error* error) {
  *out = NULL;
  rock_export* file = calloc(1, sizeof *file);
  char* path = malloc(strlen(desc->path) + 1);
  if (file == NULL || path == NULL) {
    free(file);
    free(path);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", desc->path);
  }
  strcpy(path, desc->path);
  file->desc = *desc;
  file->path = path;
  scree_result result = glb_begin(path, &file->glb, error);
  if (result != SCREE_OK) {
    rock_export_abort(file);
    return result;
  }
  *out = file;
  return SCREE_OK;
}

void rock_export_abort(rock_export* file) {
  if (file == NULL) return;
  glb_abort(file->glb);
  free(file->path);
  free(file);
}

scree_result rock_export_finish(rock_export* file, rock_export_stats* stats, scree_error* error) {
  scree_result result = glb_finish(file->glb, &file->stats.bytes, error);
  if (stats != NULL) *stats = file->stats;
  file->glb = NULL;
  rock_export_abort(file);
  return result;
}

static uint32_t shade_count(const layer_state* s) {
  if (s->layer->models != NULL) return 1;
  return s->out->desc.format == ROCK_FORMAT_FLAT && s->layer->palette->variation > 0 ? FLAT_SHADES : 1;
}

/* What the colours of hoodoos' vertices leave room for above the rock's own: loose grains are paler. */
#define BRIGHTEST 1.25f

static void add_material(layer_state* s, int which, uint32_t row, const char* name, const float linear[3], const float tint[3]) {
  float colour[3];
  for (int c = 0; c < 3; ++c) {
    colour[c] = linear[c] * tint[c];
    if (colour[c] > 1) colour[c] = 1;
  }
  s->materials[which][row] = glb_add_material(s->out->glb, name, colour);
}

static void add_materials(layer_state* s) {
  /* The skin of a cliff is darker than what frost laid bare. */
  static const float skin[3] = {0.84f, 0.85f, 0.86f}, fresh[3] = {1.10f, 1.05f, 0.98f};
  static const float bright[3] = {BRIGHTEST, BRIGHTEST, BRIGHTEST}, plain[3] = {1, 1, 1};
  const scene_palette* palette = s->layer->palette;
  uint32_t shades = shade_count(s);
  if (s->layer->models != NULL) {
    static const float white[3] = {1, 1, 1};
    s->materials[ROCK][0] = glb_add_material(s->out->glb, s->layer->name, white);
    return;
  }
  for (uint32_t i = 0; i < palette->colour_count; ++i) {
    for (uint32_t k = 0; k < shades; ++k) {
      /* The middle of each span of shades; instanced rocks have their own, so their material is the base colour itself. */
      float shade = shades == 1 ? 1.0f : 1.0f - (float)palette->variation * ((float)k + 0.5f) / (float)shades;
      float colour[3];
      char name[SCENE_NAME_SIZE + 32];
      for (int c = 0; c < 3; ++c) colour[c] = scene_linear_from_srgb(palette->colours[i][c]) * shade;
      if (s->cliff) {
        add_material(s, ROCK, i * shades + k, "rock", colour, skin);
        add_material(s, CUT, i * shades + k, "cut", colour, fresh);
        continue;
      }
      if (shades == 1) {
        snprintf(name, sizeof name, "%s stone %u", s->layer->name, i + 1);
      } else {
        snprintf(name, sizeof name, "%s stone %u.%u", s->layer->name, i + 1, k + 1);
      }
      add_material(s, ROCK, i * shades + k, name, colour, s->hoodoos ? bright : plain);
    }
  }
}

static int compare_rocks(const void* a, const void* b) {
  const rock *x = a, *y = b;
  if (x->asset != y->asset) return x->asset < y->asset ? -1 : 1;
  if (x->material != y->material) return x->material < y->material ? -1 : 1;
  return x->row < y->row ? -1 : x->row > y->row;
}

static bool sort_rocks(layer_state* s) {
  const rock_layer* layer = s->layer;
  s->rocks = malloc((layer->count > 0 ? layer->count : 1) * sizeof *s->rocks);
  if (s->rocks == NULL) return false;
  uint32_t shades = shade_count(s);
  float variation = (float)layer->palette->variation;
  for (uint32_t i = 0; i < layer->count; ++i) {
    float colour[3], shade;
    uint32_t base;
    scene_stone_colour(layer->palette, layer->hashes[i], colour, &base, &shade);
    uint32_t bucket = 0;
    if (shades > 1) {
      float place = (1.0f - shade) / variation * (float)shades;
      bucket = place < (float)(shades - 1) ? (uint32_t)place : shades - 1;
    }
    if (layer->models != NULL) base = 0, shade = 1;
    s->rocks[i] = (rock){layer->instances[i].asset, base * shades + bucket, i, shade};
  }
  qsort(s->rocks, layer->count, sizeof *s->rocks, compare_rocks);
  return true;
}

static uint8_t unit_byte(float value) {
  return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : 255 * value + 0.5f);
}

/* The tint of a vertex of a hoodoo: by its bed, or pale where it is of loose grains; darker in hollows. */
static void hoodoo_tint(const scree_vertex* v, float tint[3]) {
  static const float pale[3] = {1.0f, 1.02f, 1.05f}, dark[3] = {0.92f, 0.84f, 0.78f}, light[3] = {1.06f, 1.06f, 1.05f};
  uint32_t h = (uint32_t)(v->material >> 4) * UINT32_C(2654435761) + 97;
  h = scene_model_hash(h);
  const float t = (float)(h >> 8) / 16777216.0f, bend = (float)v->curvature / 127.0f;
  const float level = (1 + 0.2f * (bend < 0 ? bend : 0.4f * bend)) * (float)v->occlusion / 255.0f / BRIGHTEST;
  const bool is_loose = (v->material & 15) != 0;
  for (int c = 0; c < 3; ++c) tint[c] = level * (is_loose ? 1.15f * pale[c] : dark[c] + (light[c] - dark[c]) * t);
}

static void colour_part(const layer_state* s, uint32_t asset, part* it) {
  for (uint32_t i = 0; i < it->vertex_count; ++i) {
    uint8_t* colour = &it->colours[4 * (size_t)i];
    memset(colour, it->vertices[i].occlusion, 3);
    colour[3] = 255;
    float tint[3];
    if (s->hoodoos) hoodoo_tint(&it->vertices[i], tint);
    if (s->layer->models != NULL) memcpy(tint, &s->layer->models->models[asset].mesh.colours[3 * (size_t)i], sizeof tint);
    for (int c = 0; c < 3 && (s->hoodoos || s->layer->models != NULL); ++c) colour[c] = unit_byte(tint[c]);
  }
}

/* A model from a file, on the lattice of its set. */
static scree_result copy_model(const layer_state* s, uint32_t asset, part* it) {
  uint16_t* narrow = malloc((size_t)it->triangle_count * 3 * sizeof *narrow);
  if (narrow == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  scene_models_vertices(s->layer->models, asset, it->vertices, narrow);
  for (size_t i = 0; i < (size_t)it->triangle_count * 3; ++i) it->indices[i] = narrow[i];
  free(narrow);
  return SCREE_OK;
}

static bool has_uvs(const layer_state* s) {
  return s->uv_max[0] > s->uv_min[0] || s->uv_max[1] > s->uv_min[1];
}

static void free_part(part* it) {
  free(it->vertices);
  free(it->colours);
  free(it->uvs);
  free(it->indices);
  free(it->draco.bytes);
  *it = (part){0};
}

static bool make_room(part* it, uint32_t vertices, uint32_t triangles, bool uvs) {
  it->vertex_count = vertices;
  it->triangle_count = triangles;
  if (vertices == 0 || triangles == 0) return true;
  it->vertices = malloc(vertices * sizeof *it->vertices);
  it->colours = malloc((size_t)vertices * 4);
  it->uvs = uvs ? malloc((size_t)vertices * 2 * sizeof *it->uvs) : NULL;
  it->indices = malloc((size_t)triangles * 3 * sizeof *it->indices);
  return it->vertices != NULL && it->colours != NULL && (it->uvs != NULL || !uvs) && it->indices != NULL;
}

static scree_result read_uvs(const layer_state* s, uint32_t asset, part* it) {
  scree_uv* uvs = malloc(it->vertex_count * sizeof *uvs);
  if (uvs == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  const scree_result result = scree_draco_decode_uvs(s->layer->pack, asset, s->lod, uvs, NULL, it->vertex_count);
  for (size_t i = 0; i < it->vertex_count && result == SCREE_OK; ++i) {
    it->uvs[2 * i] = s->uv_min[0] + (s->uv_max[0] - s->uv_min[0]) * (float)uvs[i].u / 65535.0f;
    it->uvs[2 * i + 1] = s->uv_min[1] + (s->uv_max[1] - s->uv_min[1]) * (float)uvs[i].v / 65535.0f;
  }
  free(uvs);
  return result;
}

static bool is_cut(const part* it, uint32_t triangle) {
  const uint32_t* v = &it->indices[3 * (size_t)triangle];
  for (int k = 0; k < 3; ++k) {
    if ((it->vertices[v[k]].material & 15) != 2) return false;
  }
  return true;
}

/* The triangles of `whole` that are cuts, or those that are none, with the vertices that they use. rows: a number a vertex. */
static bool take_part(const part* whole, bool cuts, uint32_t* rows, part* out) {
  uint32_t vertices = 0, triangles = 0;
  memset(rows, 0xff, whole->vertex_count * sizeof *rows);
  for (uint32_t i = 0; i < whole->triangle_count; ++i) {
    if (is_cut(whole, i) != cuts) continue;
    ++triangles;
    for (size_t k = 0; k < 3; ++k) {
      uint32_t* row = &rows[whole->indices[3 * (size_t)i + k]];
      if (*row == UINT32_MAX) *row = vertices++;
    }
  }
  if (!make_room(out, vertices, triangles, whole->uvs != NULL)) return false;
  for (size_t i = 0; i < whole->vertex_count; ++i) {
    if (rows[i] == UINT32_MAX) continue;
    out->vertices[rows[i]] = whole->vertices[i];
    if (whole->uvs != NULL) memcpy(&out->uvs[2 * (size_t)rows[i]], &whole->uvs[2 * i], 2 * sizeof *out->uvs);
  }
  uint32_t* to = out->indices;
  for (uint32_t i = 0; i < whole->triangle_count; ++i) {
    for (size_t k = 0; k < 3 && is_cut(whole, i) == cuts; ++k) *to++ = rows[whole->indices[3 * (size_t)i + k]];
  }
  return true;
}

static scree_result split_cuts(shape* it) {
  part whole = it->parts[ROCK];
  it->parts[ROCK] = (part){0};
  uint32_t* rows = malloc(whole.vertex_count * sizeof *rows);
  const bool good =
      rows != NULL && take_part(&whole, false, rows, &it->parts[ROCK]) && take_part(&whole, true, rows, &it->parts[CUT]);
  free(rows);
  free_part(&whole);
  return good ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

static bool is_empty(const part* it) {
  return it->vertex_count == 0 || it->triangle_count == 0;
}

static scree_result encode_part(const layer_state* s, part* it) {
  glb_draco_mesh mesh = {.vertices = it->vertices,
                         .colours = it->colours,
                         .uvs = it->uvs,
                         .uv_min = {s->uv_min[0], s->uv_min[1]},
                         .vertex_count = it->vertex_count,
                         .indices = it->indices,
                         .triangle_count = it->triangle_count};
  mesh.uv_span = fmaxf(s->uv_max[0] - s->uv_min[0], s->uv_max[1] - s->uv_min[1]);
  return glb_draco_encode(&mesh, &it->draco);
}

/* Decodes one shape and, for the instanced form, encodes it again: the part that runs on all threads. */
static void make_shape(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  layer_state* s = context;
  shape* it = &s->shapes[index];
  part* whole = &it->parts[ROCK];
  const scene_models* models = s->layer->models;
  scree_lod lod = {.vertices = 0};
  it->result = SCREE_OK;
  if (models == NULL) {
    it->result = scree_pack_get_lod(s->layer->pack, it->asset, s->lod, &lod);
  } else if (it->asset < models->count) {
    lod.vertices = models->models[it->asset].mesh.vertex_count;
    lod.triangles = models->models[it->asset].mesh.triangle_count;
  } else {
    it->result = SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (it->result != SCREE_OK) return;
  if (!make_room(whole, lod.vertices, lod.triangles, has_uvs(s))) it->result = SCREE_ERROR_OUT_OF_MEMORY;
  if (it->result != SCREE_OK || is_empty(whole)) return;
  it->result = models != NULL ? copy_model(s, it->asset, whole)
                              : scree_draco_decode_u32(s->layer->pack, it->asset, s->lod, whole->vertices, lod.vertices,
                                                       whole->indices, (size_t)lod.triangles * 3);
  if (it->result == SCREE_OK && whole->uvs != NULL) it->result = read_uvs(s, it->asset, whole);
  if (it->result == SCREE_OK && s->cliff) it->result = split_cuts(it);
  for (int i = 0; i < PARTS && it->result == SCREE_OK; ++i) {
    if (is_empty(&it->parts[i])) continue;
    colour_part(s, it->asset, &it->parts[i]);
    if (s->out->desc.format == ROCK_FORMAT_INSTANCED) it->result = encode_part(s, &it->parts[i]);
  }
}

static void free_shape(shape* it) {
  for (int i = 0; i < PARTS; ++i) free_part(&it->parts[i]);
  *it = (shape){0};
}

static void bounds_of(const part* it, float scale, float min[3], float max[3]) {
  for (int k = 0; k < 3; ++k) min[k] = max[k] = (float)it->vertices[0].position[k] * scale;
  for (uint32_t i = 1; i < it->vertex_count; ++i) {
    for (int k = 0; k < 3; ++k) {
      float value = (float)it->vertices[i].position[k] * scale;
      if (value < min[k]) min[k] = value;
      if (value > max[k]) max[k] = value;
    }
  }
}

/* The accessors of a primitive as plain arrays. */
static bool write_plain(layer_state* s, const part* it, glb_mesh* mesh) {
  glb_writer* glb = s->out->glb;
  uint32_t count = it->vertex_count;
  float* numbers = malloc((size_t)count * 3 * sizeof *numbers);
  uint16_t* narrow = malloc((size_t)it->triangle_count * 3 * sizeof *narrow);
  bool good = numbers != NULL && narrow != NULL;
  if (good) {
    float min[3], max[3];
    bounds_of(it, s->step, min, max);
    for (size_t i = 0; i < (size_t)count * 3; ++i) numbers[i] = (float)it->vertices[i / 3].position[i % 3] * s->step;
    mesh->positions = glb_add_data(glb, GLB_POSITIONS, numbers, count, min, max);
    for (size_t i = 0; i < (size_t)count * 3; ++i) numbers[i] = (float)it->vertices[i / 3].normal[i % 3] / 32767.0f;
    mesh->normals = glb_add_data(glb, GLB_NORMALS, numbers, count, NULL, NULL);
    mesh->colours = glb_add_data(glb, GLB_COLOURS, it->colours, count, NULL, NULL);
    if (it->uvs != NULL) mesh->uvs = glb_add_data(glb, GLB_UVS, it->uvs, count, NULL, NULL);
    /* 65535 is no vertex: it restarts strips. */
    if (count <= UINT16_MAX) {
      for (size_t i = 0; i < (size_t)it->triangle_count * 3; ++i) narrow[i] = (uint16_t)it->indices[i];
      mesh->indices = glb_add_data(glb, GLB_INDICES16, narrow, it->triangle_count * 3, NULL, NULL);
    } else {
      mesh->indices = glb_add_data(glb, GLB_INDICES32, it->indices, it->triangle_count * 3, NULL, NULL);
    }
  }
  free(numbers);
  free(narrow);
  return good;
}

static void write_draco(layer_state* s, const part* it, glb_mesh* mesh) {
  glb_writer* glb = s->out->glb;
  float min[3], max[3];
  bounds_of(it, 1.0f, min, max);
  mesh->positions = glb_add_accessor(glb, GLB_POSITIONS, it->draco.points, min, max);
  mesh->normals = glb_add_accessor(glb, GLB_NORMALS, it->draco.points, NULL, NULL);
  mesh->colours = glb_add_accessor(glb, GLB_COLOURS, it->draco.points, NULL, NULL);
  if (it->uvs != NULL) mesh->uvs = glb_add_accessor(glb, GLB_UVS, it->draco.points, NULL, NULL);
  glb_stream indices = it->draco.points <= UINT16_MAX ? GLB_INDICES16 : GLB_INDICES32;
  mesh->indices = glb_add_accessor(glb, indices, it->draco.triangles * 3, NULL, NULL);
  mesh->blob = glb_add_blob(glb, it->draco.bytes, it->draco.size);
  mesh->position_id = it->draco.position_id;
  mesh->normal_id = it->draco.normal_id;
  mesh->colour_id = it->draco.colour_id;
  mesh->uv_id = it->draco.uv_id;
}

/* The unit quaternion of a turn about +Y. */
static void quaternion_of(const rock_turn* turn, double q[4]) {
  const double c = (double)turn->cosine, s = (double)turn->sine;
  q[0] = q[2] = 0;
  if (c > -0.5) {
    q[3] = sqrt(0.5 * (1 + c));
    q[1] = 0.5 * s / q[3];
  } else {
    q[1] = sqrt(0.5 * (1 - c));
    q[3] = 0.5 * s / q[1];
  }
}

/* Rotation and scale of each instance. */
static bool write_turns(layer_state* s, const rock* rocks, uint32_t count, glb_node* node) {
  float* numbers = malloc((size_t)count * 7 * sizeof *numbers);
  if (numbers == NULL) return false;
  float* scales = numbers + (size_t)count * 4;
  for (uint32_t i = 0; i < count; ++i) {
    const rock_turn* turn = &s->layer->turns[rocks[i].row];
    double q[4];
    quaternion_of(turn, q);
    for (size_t k = 0; k < 4; ++k) numbers[4 * (size_t)i + k] = (float)q[k];
    for (size_t k = 0; k < 3; ++k) scales[3 * (size_t)i + k] = turn->scale;
  }
  node->rotations = glb_add_data(s->out->glb, GLB_ROTATIONS, numbers, count, NULL, NULL);
  node->scales = glb_add_data(s->out->glb, GLB_SCALES, scales, count, NULL, NULL);
  free(numbers);
  return true;
}

/* Nodes of `count` rocks that share shape and material. */
static bool write_rocks(layer_state* s, const rock* rocks, uint32_t count, uint32_t mesh) {
  glb_writer* glb = s->out->glb;
  const scree_instance* instances = s->layer->instances;
  const rock_turn* turns = s->layer->turns;
  glb_node node = {.mesh = mesh, .translations = GLB_NONE, .instance_colours = GLB_NONE, .rotations = GLB_NONE, .scales = GLB_NONE};
  if (s->out->desc.format == ROCK_FORMAT_FLAT) {
    for (uint32_t i = 0; i < count; ++i) {
      for (int k = 0; k < 3; ++k) node.translation[k] = (double)instances[rocks[i].row].position[k];
      if (turns != NULL) {
        quaternion_of(&turns[rocks[i].row], node.rotation);
        node.scale = (double)turns[rocks[i].row].scale;
      }
      glb_add_node(glb, &node);
      ++s->nodes;
    }
    return true;
  }
  float* places = malloc((size_t)count * 6 * sizeof *places);
  if (places == NULL) return false;
  float* shades = places + (size_t)count * 3;
  for (uint32_t i = 0; i < count; ++i) {
    for (size_t k = 0; k < 3; ++k) {
      places[3 * (size_t)i + k] = (float)((double)instances[rocks[i].row].position[k] / (double)s->step);
      shades[3 * (size_t)i + k] = rocks[i].shade;
    }
  }
  node.translations = glb_add_data(glb, GLB_TRANSLATIONS, places, count, NULL, NULL);
  node.instance_colours = glb_add_data(glb, GLB_INSTANCE_COLOURS, shades, count, NULL, NULL);
  free(places);
  if (turns != NULL && !write_turns(s, rocks, count, &node)) return false;
  glb_add_node(glb, &node);
  ++s->nodes;
  return true;
}

/* Writes a shape with all its rocks, which begin at `rocks`. Returns how many they are, 0 when memory is short. */
static uint32_t write_shape(layer_state* s, const shape* it, const rock* rocks, uint32_t left) {
  glb_mesh meshes[PARTS], *mesh = NULL;
  char name[SCENE_NAME_SIZE + 16];
  uint32_t count = 0, triangles = 0;
  snprintf(name, sizeof name, "%s %u", s->layer->name, it->asset);
  for (int i = PARTS - 1; i >= 0; --i) {
    meshes[i] = (glb_mesh){.name = name, .uvs = GLB_NONE, .blob = GLB_NONE, .also = mesh};
    if (is_empty(&it->parts[i])) continue;
    mesh = &meshes[i];
    triangles += it->parts[i].triangle_count;
    if (s->out->desc.format == ROCK_FORMAT_INSTANCED) {
      write_draco(s, &it->parts[i], mesh);
    } else if (!write_plain(s, &it->parts[i], mesh)) {
      return 0;
    }
  }
  if (mesh != NULL) ++s->stats.shapes;
  while (count < left && rocks[count].asset == it->asset) {
    uint32_t first = count;
    while (count < left && rocks[count].asset == it->asset && rocks[count].material == rocks[first].material) ++count;
    if (mesh == NULL) continue;
    for (int i = 0; i < PARTS; ++i) meshes[i].material = s->materials[i][rocks[first].material];
    if (!write_rocks(s, rocks + first, count - first, glb_add_mesh(s->out->glb, mesh))) return 0;
    s->stats.triangles += (uint64_t)triangles * (count - first);
  }
  return count;
}

static scree_result fail_shape(const layer_state* s, const shape* it, scree_error* error) {
  return fail_with(error, it->result, "%s: rock %u of the pack, level %u: %s", s->layer->name, it->asset, s->lod,
                   scree_result_string(it->result));
}

static scree_result write_shapes(layer_state* s, scree_error* error) {
  uint32_t total = (uint32_t)s->layer->count, done = 0;
  const scree_jobs* jobs = &s->out->desc.jobs;
  scree_result result = SCREE_OK;
  while (done < total && result == SCREE_OK) {
    uint32_t shapes = 0;
    for (uint32_t i = done; i < total; ++i) {
      if (i > done && s->rocks[i].asset == s->rocks[i - 1].asset) continue;
      if (shapes == BATCH) break;
      s->shapes[shapes++] = (shape){.asset = s->rocks[i].asset};
    }
    if (jobs->parallel_for != NULL) {
      jobs->parallel_for(jobs->user, shapes, make_shape, s);
    } else {
      for (uint32_t i = 0; i < shapes; ++i) make_shape(s, i, 0);
    }
    for (uint32_t i = 0; i < shapes; ++i) {
      if (result == SCREE_OK && s->shapes[i].result != SCREE_OK) result = fail_shape(s, &s->shapes[i], error);
      if (result == SCREE_OK) {
        uint32_t written = write_shape(s, &s->shapes[i], s->rocks + done, total - done);
        if (written == 0) result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->out->path);
        done += written;
      }
      free_shape(&s->shapes[i]);
    }
    if (s->out->desc.progress != NULL) s->out->desc.progress(s->out->desc.user, (double)done / total);
  }
  return result;
}

static scree_result add_layer(layer_state* s, scree_error* error) {
  if (!sort_rocks(s)) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", s->out->path);
  add_materials(s);
  scree_result result = write_shapes(s, error);
  if (result != SCREE_OK || s->nodes == 0) return result;
  const rock_layer* layer = s->layer;
  glb_node group = {.name = layer->name,
                    .mesh = GLB_NONE,
                    .translation = {layer->origin[0], layer->origin[1], layer->origin[2]},
                    .translations = GLB_NONE,
                    .instance_colours = GLB_NONE,
                    .rotations = GLB_NONE,
                    .scales = GLB_NONE,
                    .first_child = s->first_node,
                    .child_count = s->nodes,
                    .is_root = true};
  if (s->out->desc.format == ROCK_FORMAT_INSTANCED) group.scale = (double)s->step;
  glb_add_node(s->out->glb, &group);
  return SCREE_OK;
}

scree_result rock_export_add(rock_export* file, const rock_layer* layer, rock_export_stats* stats, scree_error* error) {
  if (layer->count > INT32_MAX) return fail_with(error, SCREE_ERROR_RANGE, "%s: more than 2^31 rocks", layer->name);
  if (layer->palette->colour_count < 1 || layer->palette->colour_count > SCENE_PALETTE_MAX)
    return fail_with(error, SCREE_ERROR_RANGE, "%s: the palette needs 1..%d colours", layer->name, SCENE_PALETTE_MAX);
  layer_state s = {.out = file, .layer = layer};
  if (layer->models != NULL) {
    s.step = (float)(layer->cell_size / (double)layer->models->steps_per_metre);
  } else {
    scree_pack_info info;
    scree_pack_get_info(layer->pack, &info);
    s.lod = file->desc.lod < info.lod_count ? file->desc.lod : info.lod_count - 1;
    s.step = (float)(layer->cell_size / info.lattice_per_cell);
    s.hoodoos = info.kind == SCREE_PACK_MODELS;
    s.cliff = info.kind == SCREE_PACK_CLIFF;
    memcpy(s.uv_min, info.uv_min, sizeof s.uv_min);
    memcpy(s.uv_max, info.uv_max, sizeof s.uv_max);
  }
  s.first_node = glb_node_count(file->glb);
  s.shapes = calloc(BATCH, sizeof *s.shapes);
  scree_result result;
  if (s.shapes == NULL) {
    result = fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", file->path);
  } else {
    result = add_layer(&s, error);
  }
  free(s.rocks);
  free(s.shapes);
  s.stats.instances = layer->count;
  file->stats.instances += layer->count;
  file->stats.triangles += s.stats.triangles;
  file->stats.shapes += s.stats.shapes;
  if (stats != NULL) *stats = s.stats;
  return result;
}
