/* The far field: a cube of level k is 2^k cubes wide and is drawn with the proxies of one tile, 2^k times as large.
 *
 *   one axis of a cube of N = 5 cells       [  0  ][  1  ][  2  ][  3  ][  4  ]
 *   its parts, of (N + 1) / 2 and N / 2     [      low part      ][  high part ]        a part exists where its middle (x) does
 *                                                     x                 x
 *   as a field of 2 cells a cube            [     cell 0     ][     cell 1     ]        cells are alike, the "centroid" of a cell's
 *                                                                                       one rock is the middle of the part
 *
 * So each level is a field of its own, with one rock a cell and the same rocks in all tiles, which is made in some hundred
 * nanoseconds where it is needed, and the queries that find rocks find parts. Parts whose 26 neighbours exist are culled like
 * rocks with a burial of 1.
 *
 *   a layer thinner than a part           [     ][     ][     ][     ]
 *   slips through between the             [  x  ][  x  ][  x  ][. x .]      thin parts: along the axis on which the support is
 *   middles: there parts exist            [     ][.....][.....]     ]       crossed most steeply, the middle nearest to it
 *   that are nearest to it                [ ... ][  x  ][  x  ][  x  ]
 *
 * Thin parts lie outside, at most half a part away, and nearer than both neighbours along one axis: that of the largest rise of
 * the distance, or nearly so. Of a plane sheet that leaves one part of each column along the axis, at least, so without holes;
 * beside a support that is thicker than a part there is none, because the next middle inwards is inside. (Asking that no neighbour
 * at all be inside leaves holes: beside each column that does have a middle inside.) They hide nothing and are never culled. */
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "scene_layers.h"

enum { FAR_CELLS = 2, FAR_PARTS = 8, FAR_PADDED = 16 };

/* The tables of a field of parts, as field_tables.h has them. */
typedef struct far_tables {
  scree_field field;
  scree_scene scene;
  scene_layer layer;
  _Alignas(64) float xyz[3][FAR_PADDED];
  uint32_t assets[FAR_PADDED]; /* right behind xyz: field_slots counts on it */
  _Alignas(64) uint32_t locals[FAR_PADDED];
  uint8_t cells[4][FAR_PADDED]; /* right behind locals */
  float mean_radius[FAR_PADDED];
  uint8_t places[FAR_PARTS][4];
  field_asset parts[FAR_PARTS];
  field_hiding hidings[FAR_PARTS];
} far_tables;

_Static_assert(offsetof(far_tables, assets) - offsetof(far_tables, xyz) == 12 * FAR_PADDED, "as in field_slots");
_Static_assert(offsetof(far_tables, cells) - offsetof(far_tables, locals) == 4 * FAR_PADDED, "as in field_slots");

/* Where a part's middle is along an axis, relative to the centre of its cell of the field of parts; `cell` is the size of a cell
 * of the tile. */
static double middle_offset(uint32_t n, double cell, bool high) {
  double low_part = (double)((n + 1) / 2) * cell, all = n * cell;
  return high ? (low_part + all) * 0.5 - all * 0.75 : low_part * 0.5 - all * 0.25;
}

static void make_tables(far_tables* t, const scene_layer* layer, double scale) {
  const scree_field* from = layer->given.field;
  scree_field* field = &t->field;
  memset(t, 0, sizeof *t);
  double cell = from->cell_size * scale; /* of the tile, as it is drawn */
  field->seed = from->seed;
  field->cells_per_cube = FAR_CELLS;
  field->max_rocks_per_cell = 1;
  field->per_cell_inverse = field_cell_inverse(1);
  field->uniform_count = FAR_PARTS;
  field->cell_size = cell * from->cells_per_cube * 0.5;
  field->max_radius = 1;
  field->deepest_burial = 1;
  field->asset_count = FAR_PARTS;
  memcpy(field->lane_order, from->lane_order, sizeof field->lane_order);
  double reach2 = 0;
  for (int a = 0; a < 3; ++a) {
    /* Cells are centred on corners, so the first cube starts half a cell before the origin, whatever the level. */
    field->origin[a] = from->origin[a] - from->cell_size * 0.5 + field->cell_size * 0.5;
    float low = (float)middle_offset(from->cells_per_cube, cell, false),
          high = (float)middle_offset(from->cells_per_cube, cell, true);
    field->centroid_min[a] = low < high ? low : high;
    field->centroid_max[a] = low < high ? high : low;
    reach2 += (double)low * (double)low > (double)high * (double)high ? (double)low * (double)low : (double)high * (double)high;
  }
  field->centroid_reach = (float)(sqrt(reach2) * 1.000001);
  float radius = (from->mean_radius_min + from->mean_radius_max) * 0.5f; /* of rocks: thresholds move surfaces no farther */
  field->mean_radius_min = field->mean_radius_max = radius;
  for (uint32_t i = 0; i < FAR_PARTS; ++i) {
    float* ball[3] = {&field->balls.x[i], &field->balls.y[i], &field->balls.z[i]};
    for (uint32_t a = 0; a < 3; ++a) {
      bool high = i >> a & 1;
      t->cells[a][i] = t->places[i][a] = high;
      t->xyz[a][i] = (float)middle_offset(from->cells_per_cube, cell, high);
      *ball[a] = (float)((high ? field->cell_size : 0) + (double)t->xyz[a][i]);
    }
    field->balls.radius[i] = (float)field->cell_size * 1e-6f;
    t->assets[i] = t->locals[i] = i;
    t->mean_radius[i] = radius;
    t->hidings[i] = (field_hiding){1, 1};
  }
  for (uint32_t code = 0; code < 256; ++code) {
    field_tile* tile = &field->tiles[code];
    tile->padded = FAR_PADDED;
    for (uint32_t b = 0; b <= FIELD_BLOCKS; ++b) tile->block_first[b] = (uint16_t)b;
  }
  field->rocks = (uint8_t*)t->xyz;
  field->layouts = (uint8_t*)t->locals;
  field->mean_radius = t->mean_radius;
  field->cell_places = t->places;
  field->assets = t->parts;
  field->hidings = t->hidings;

  t->layer.given = layer->given;
  t->layer.given.field = field;
  /* A shell thinner than a part would leave holes. */
  float thickest = (float)(field->cell_size * 2 * layer->lipschitz);
  if (layer->given.shell_depth > 0 && layer->given.shell_depth < thickest) t->layer.given.shell_depth = thickest;
  scree_rt_scene_measure(&t->layer, field->origin);
  t->scene.layer_count = 1;
  memcpy(t->scene.base, field->origin, sizeof t->scene.base);
  t->scene.layers = &t->layer;
}

/* Where the middle of a part is in the support's space, as the query has it. */
static void find_middle(const far_tables* t, const double base[3], const int64_t part[3], float at[3]) {
  for (int a = 0; a < 3; ++a) at[a] = (float)(base[a] + t->field.cell_size * (double)part[a]) + t->xyz[a][(part[a] & 1) << a];
}

enum { THIN_POINTS = 7, THIN_BATCH = 9 }; /* a middle, then along each axis the next and the one before */

#define THIN_AXES 0.7f /* of the largest rise: enough for slopes near 45 degrees, where neighbours differ about the axis */

/* Whether a part whose middle is outside is thin, by the distances at its middle and at those beside it. */
static bool is_thin(const float d[THIN_POINTS]) {
  float rise[3], most = 0;
  for (int a = 0; a < 3; ++a) {
    rise[a] = (d[1 + 2 * a] > d[2 + 2 * a] ? d[1 + 2 * a] : d[2 + 2 * a]) - d[0];
    if (rise[a] > most) most = rise[a];
  }
  bool thin = false;
  for (int a = 0; a < 3; ++a) thin = thin || (rise[a] >= most * THIN_AXES && d[0] < d[1 + 2 * a] && d[0] <= d[2 + 2 * a]);
  return thin;
}

/* Adds the thin parts of the cells to the parts that were found: `instances` and `ids` from `first` on. */
static scree_result find_thin_parts(far_tables* t, const int64_t low[3], const int64_t high[3], const double origin[3],
                                    scree_scratch* scratch, uint64_t first, uint64_t* count) {
  const scene_layer* layer = &t->layer;
  const scree_support* support = layer->given.support;
  double threshold = layer->given.threshold > 0 ? (double)layer->given.threshold : 0.5, steepest = layer->lipschitz;
  cell_query query = {.field = &t->field, .support = support, .threshold = 0.25f, .outside = true};
  query.above = (float)(1 - 2 * threshold) * t->field.mean_radius_max;
  float radius = 2 * (query.above + (float)(t->field.cell_size * 0.5 * (steepest > 1 ? steepest : 1)));
  t->field.mean_radius_min = t->field.mean_radius_max = radius; /* a threshold of a quarter moves surfaces by half of it */
  for (uint32_t i = 0; i < FAR_PARTS; ++i) t->mean_radius[i] = radius;
  memcpy(query.origin, origin, sizeof query.origin);
  memcpy(query.low, low, sizeof query.low);
  memcpy(query.high, high, sizeof query.high);
  uint64_t found = 0;
  for (size_t room = FIELD_OCTET;; room = (size_t)found + FIELD_OCTET) {
    scree_instance* instances = scree_rt_scratch_extend(scratch, SCRATCH_INSTANCES, first, first + room, sizeof *instances);
    scree_id* ids = scree_rt_scratch_extend(scratch, SCRATCH_IDS, first, first + room, sizeof *ids);
    if (instances == NULL || ids == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    size_t more = scratch_room(scratch, SCRATCH_INSTANCES, sizeof *instances),
           others = scratch_room(scratch, SCRATCH_IDS, sizeof *ids);
    room = (more < others ? more : others) - (size_t)first;
    scree_result result = scree_rt_query_cells(&query, instances + first, ids + first, room, &found);
    if (result == SCREE_OK) break;
    if (result != SCREE_ERROR_CAPACITY) return result;
  }
  scree_instance* instances = (scree_instance*)scratch->buffers[SCRATCH_INSTANCES].memory + first;
  scree_id* ids = (scree_id*)scratch->buffers[SCRATCH_IDS].memory + first;
  double base[3];
  for (int a = 0; a < 3; ++a) base[a] = t->field.origin[a] - support->origin[a];
  uint64_t kept = 0;
  for (uint64_t from = 0; from < found; from += THIN_BATCH) {
    uint32_t batch = found - from < THIN_BATCH ? (uint32_t)(found - from) : THIN_BATCH;
    float x[THIN_BATCH * THIN_POINTS], y[THIN_BATCH * THIN_POINTS], z[THIN_BATCH * THIN_POINTS], d[THIN_BATCH * THIN_POINTS];
    for (uint32_t i = 0; i < batch; ++i) {
      for (uint32_t k = 0; k < THIN_POINTS; ++k) {
        int64_t part[3];
        float at[3];
        for (uint32_t a = 0; a < 3; ++a) part[a] = (int64_t)ids[from + i].cube[a] * FAR_CELLS + t->places[ids[from + i].local][a];
        if (k > 0) part[(k - 1) / 2] += (k & 1) ? 1 : -1;
        find_middle(t, base, part, at);
        x[i * THIN_POINTS + k] = at[0];
        y[i * THIN_POINTS + k] = at[1];
        z[i * THIN_POINTS + k] = at[2];
      }
    }
    scree_support_distance(support, x, y, z, d, batch * THIN_POINTS);
    for (uint32_t i = 0; i < batch; ++i) {
      if (!is_thin(&d[i * THIN_POINTS]) || (layer->filtered && !scree_rt_scene_passes(layer, &ids[from + i]))) continue;
      instances[kept] = instances[from + i];
      ids[kept++] = ids[from + i];
    }
  }
  *count = kept;
  return SCREE_OK;
}

static bool has_proxies(const scree_field* field) {
  if (field->pack == NULL) return true; /* a field of a test */
  scree_pack_info info;
  scree_pack_get_info(field->pack, &info);
  return info.proxy_count > 0;
}

static uint32_t proxy_of(const scree_field* field, uint32_t code, uint32_t part) {
  return field->pack != NULL ? scree_pack_proxy(field->pack, code, part) : field->asset_count + 9 * code + part;
}

scree_result scree_rt_scene_far(const scree_scene* scene, uint32_t layer, uint32_t far_level, const int32_t cube_low[3],
                                const int32_t cube_high[3], const double origin[3], scree_scratch* scratch,
                                const scree_rock** proxies, uint64_t* count) {
  *proxies = NULL;
  *count = 0;
  const scree_field* field = scene->layers[layer].given.field;
  if (!has_proxies(field)) return SCREE_OK;
  far_tables* tables = scree_rt_scratch_reserve(scratch, SCRATCH_FAR, 1, sizeof *tables);
  if (tables == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  double scale = 1;
  for (uint32_t i = 0; i < far_level; ++i) scale *= 2;
  make_tables(tables, &scene->layers[layer], scale);

  scene_question q;
  int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = (int64_t)cube_low[a] * FAR_CELLS;
    high[a] = (int64_t)cube_high[a] * FAR_CELLS;
  }
  scree_result result = scree_rt_scene_answer(&q, &tables->scene, NULL, 0, low, high, origin, true, UINT64_MAX, scratch);
  if (result != SCREE_OK) return result;
  layer_rocks* parts = &q.layers[0];
  uint64_t thin;
  result = find_thin_parts(tables, low, high, origin, scratch, parts->first + parts->count, &thin);
  if (result != SCREE_OK) return result;
  q.instances = scratch->buffers[SCRATCH_INSTANCES].memory;
  q.ids = scratch->buffers[SCRATCH_IDS].memory;
  parts->count += thin;
  scree_rock* rocks = scree_rt_scratch_reserve(scratch, SCRATCH_ROCKS, parts->count + 1, sizeof *rocks);
  if (rocks == NULL) return SCREE_ERROR_OUT_OF_MEMORY;

  double h = field->cell_size, width = h * scale * field->cells_per_cube;
  uint64_t end = parts->first + parts->count, delivered = 0;
  for (uint64_t first = parts->first, next; first < end; first = next) {
    const scree_id* id = &q.ids[first];
    for (next = first; next < end && memcmp(q.ids[next].cube, id->cube, sizeof id->cube) == 0; ++next) {}
    bool inside = true;
    for (int a = 0; a < 3; ++a) inside = inside && id->cube[a] >= cube_low[a] && id->cube[a] < cube_high[a];
    if (!inside) continue;
    scree_rock rock = {.id = *id};
    rock.id.layer = scene->layers[layer].given.key;
    for (int a = 0; a < 3; ++a)
      rock.position[a] = (float)((field->origin[a] - origin[a]) + width * (double)id->cube[a] + h * (scale - 1) * 0.5);
    uint32_t code = scree_field_tile_code(field, id->cube);
    bool whole = next - first == FAR_PARTS;
    for (uint64_t i = first; i < (whole ? first + 1 : next); ++i) {
      rock.id.local = (uint16_t)(whole ? 0 : 1 + q.instances[i].asset);
      rock.asset = proxy_of(field, code, rock.id.local);
      rocks[delivered++] = rock;
    }
  }
  *proxies = rocks;
  *count = delivered;
  return SCREE_OK;
}
