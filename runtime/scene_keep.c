/* The rule of overlaps: a rock is dropped if its hull meets the hull of a kept rock of an earlier layer.
 *
 * Where few rocks are asked about many, a map tells those that are far from all. For the others, the kept rocks lie sorted by cells
 * of space, layer by layer. Two balls round the centroids tell most pairs apart, first in floats; hulls decide the rest. All places
 * are relative to the scene's base and computed from the integers of cells, so that a pair is judged alike in every question. */
#include <math.h>
#include <string.h>

#include "convex.h"
#include "near_map.h"
#include "scene_scatter.h"
#include "simd.h"

/* A kept rock that later layers may meet. */
typedef struct kept_rock {
  double centroid[3], home[3]; /* relative to the scene's base */
  double radius;               /* of the ball round the centroid that holds it */
  uint32_t asset;              /* of a scatter, a place in the list of parts */
  uint32_t cell;               /* of those of its layer */
} kept_rock;

/* A part of an instance of a scatter, of which each is kept, and met, by itself. */
typedef struct kept_part {
  uint32_t part, random; /* of all parts of the scatter; of the instance */
} kept_part;

static kept_rock place_part(const scene_question* q, const scene_layer* layer, uint64_t i, uint32_t part, kept_part* kept) {
  const scree_scatter* s = layer->given.scatter;
  const uint32_t packed = q->instances[i].asset;
  kept_rock rock = {0};
  rock.radius = scree_rt_scene_scatter_ball(layer, &q->ids[i], packed, part, q->scene->base, rock.home, rock.centroid);
  *kept = (kept_part){s->models[scatter_model_of(packed)].first_part + part, scree_scatter_random(s, &q->ids[i])};
  return rock;
}

static kept_rock place_rock(const scene_layer* layer, const scree_id* id, uint32_t asset) {
  const scree_field* field = layer->given.field;
  const field_asset* a = &field->assets[asset];
  kept_rock rock = {0};
  int64_t cell[3];
  rock_cell(field, id, cell);
  cell_centre(layer, cell, rock.home);
  for (int i = 0; i < 3; ++i) rock.centroid[i] = rock.home[i] + (double)a->centroid[i] * field->cell_size;
  rock.radius = (double)a->outer_radius * field->cell_size;
  rock.asset = asset;
  rock.cell = 0;
  return rock;
}

/* Whether a ball reaches into a box. */
static bool ball_meets_box(const double centre[3], double radius, const double low[3], const double high[3]) {
  double away2 = 0;
  for (int a = 0; a < 3; ++a) {
    double away = centre[a] < low[a] ? low[a] - centre[a] : centre[a] > high[a] ? centre[a] - high[a] : 0;
    away2 += away * away;
  }
  return away2 <= radius * radius;
}

/* Larger cells have more rocks, smaller ones lie in more rows. */
#define CELL_RADII 2.0

/* Cells of space that hold the centroids of a layer's kept rocks. Places are told relative to their lowest corner, so that what
 * rounding does is small against them. */
static void shape_cells(layer_rocks* rocks, double step, const double low[3], const double high[3]) {
  const double most = 64 + 4 * (double)rocks->kept_count;
  for (step = fmax(step, 1e-30);; step *= 1.25) { /* 1e-30: nothing else would make 0 wider */
    double cells = 1;
    for (int a = 0; a < 3; ++a) cells *= floor((high[a] - low[a]) / step) + 1;
    if (cells <= most) break;
  }
  rocks->cell_step = step;
  rocks->cell_inverse = 1 / step;
  rocks->cell_slack = rocks->ball_slack = 0;
  for (int a = 0; a < 3; ++a) {
    rocks->cell_low[a] = low[a];
    rocks->cell_slack += (high[a] - low[a] + step) * 1e-12; /* of rounding; of floats there is more */
    rocks->ball_slack += (high[a] - low[a] + step) * 1e-6;
    rocks->cell_count[a] = (uint32_t)((high[a] - low[a]) / step) + 1;
  }
}

/* The cell along an axis of a place relative to cell_low; places beside all cells count to the outermost ones. */
static uint32_t cell_along(const layer_rocks* rocks, int axis, double at) {
  const double cell = at * rocks->cell_inverse, last = (double)(rocks->cell_count[axis] - 1);
  return (uint32_t)(int32_t)(cell > 0 ? (cell < last ? cell : last) : 0);
}

/* The balls of a layer's kept rocks once more, for a first look: x, y, z relative to cell_low and the radius, each an array in the
 * order of the rocks with SIMD_WIDTH more that meet nothing. */
typedef struct ball_arrays {
  float *x, *y, *z, *radius;
} ball_arrays;

static ball_arrays balls_of(const scene_question* q, const layer_rocks* rocks) {
  float* first = (float*)q->scratch->buffers[SCRATCH_KEPT_BALLS].memory + rocks->ball_first;
  const size_t length = rocks->kept_count + SIMD_WIDTH;
  return (ball_arrays){first, first + length, first + 2 * length, first + 3 * length};
}

static bool fill_balls(scene_question* q, layer_rocks* rocks, const kept_rock* kept) {
  const size_t length = 4 * ((size_t)rocks->kept_count + SIMD_WIDTH);
  rocks->ball_first = q->ball_count;
  if (scree_rt_scratch_extend(q->scratch, SCRATCH_KEPT_BALLS, q->ball_count, q->ball_count + length, sizeof(float)) == NULL)
    return false;
  q->ball_count += length;
  const ball_arrays to = balls_of(q, rocks);
  for (uint32_t i = 0; i < rocks->kept_count; ++i) {
    to.x[i] = (float)(kept[i].centroid[0] - rocks->cell_low[0]);
    to.y[i] = (float)(kept[i].centroid[1] - rocks->cell_low[1]);
    to.z[i] = (float)(kept[i].centroid[2] - rocks->cell_low[2]);
    to.radius[i] = (float)(kept[i].radius * (1 + 1e-5) + rocks->ball_slack);
  }
  for (uint32_t i = rocks->kept_count; i < rocks->kept_count + SIMD_WIDTH; ++i) {
    to.x[i] = to.y[i] = to.z[i] = INFINITY;
    to.radius[i] = 0;
  }
  return true;
}

/* How many rocks are kept so far, and the box of their centroids. */
typedef struct kept_box {
  uint32_t count;
  double low[3], high[3];
} kept_box;

/* Keeps a rock, or part, where later layers can meet it. */
static inline bool add_kept(const layer_rocks* rocks, kept_box* box, kept_rock* kept, const kept_rock* rock) {
  if (!ball_meets_box(rock->centroid, rock->radius, rocks->region_low, rocks->region_high)) return false;
  for (int a = 0; a < 3; ++a) {
    box->low[a] = box->count == 0 || rock->centroid[a] < box->low[a] ? rock->centroid[a] : box->low[a];
    box->high[a] = box->count == 0 || rock->centroid[a] > box->high[a] ? rock->centroid[a] : box->high[a];
  }
  kept[box->count++] = *rock;
  return true;
}

/* Sorts the kept rocks of a layer by cells, as far as later layers can meet them: cell c, x fastest, has the rocks starts[c] ..
 * starts[c + 1] - 1 of those from kept_first on. */
static scree_result fill_cells(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  layer_rocks* rocks = &q->layers[index];
  uint64_t most = rocks->count;
  kept_part* list = NULL;
  if (layer->given.scatter != NULL) {
    for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) most += scatter_parts(layer, q->instances[i].asset) - 1;
    list = scree_rt_scratch_extend(q->scratch, SCRATCH_KEPT_PARTS, q->part_count, q->part_count + most, sizeof *list);
    if (list == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  }
  /* First all rocks behind one another, then sorted by cell into the first half. */
  kept_rock* kept = scree_rt_scratch_extend(q->scratch, SCRATCH_KEPT, q->kept_count, q->kept_count + 2 * most, sizeof *kept);
  if (kept == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  kept += q->kept_count;
  kept_rock* unsorted = kept + most;
  kept_box box = {0};
  for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) {
    if (list == NULL) {
      const kept_rock rock = place_rock(layer, &q->ids[i], q->instances[i].asset);
      add_kept(rocks, &box, unsorted, &rock);
      continue;
    }
    for (uint32_t part = 0; part < scatter_parts(layer, q->instances[i].asset); ++part) {
      kept_rock rock = place_part(q, layer, i, part, &list[q->part_count]);
      rock.asset = q->part_count;
      if (add_kept(rocks, &box, unsorted, &rock)) ++q->part_count;
    }
  }
  const uint32_t count = box.count;
  const double *low = box.low, *high = box.high;
  rocks->kept_first = q->kept_count;
  rocks->kept_count = count;
  shape_cells(rocks, CELL_RADII * layer->rock_radius, low, high);
  const uint32_t* sizes = rocks->cell_count;
  const uint32_t cells = sizes[0] * sizes[1] * sizes[2];
  uint32_t* starts =
      scree_rt_scratch_extend(q->scratch, SCRATCH_KEPT_STARTS, q->start_count, q->start_count + cells + 1, sizeof *starts);
  if (starts == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  rocks->start_first = q->start_count;
  starts += q->start_count;
  memset(starts, 0, (cells + 1) * sizeof *starts);
  for (uint32_t i = 0; i < count; ++i) {
    uint32_t at[3];
    for (int a = 0; a < 3; ++a) at[a] = cell_along(rocks, a, unsorted[i].centroid[a] - low[a]);
    unsorted[i].cell = (at[2] * sizes[1] + at[1]) * sizes[0] + at[0];
    ++starts[unsorted[i].cell];
  }
  for (uint32_t c = 0, sum = 0; c <= cells; ++c) { /* ends; the next pass counts them down to the starts */
    sum += starts[c];
    starts[c] = sum;
  }
  for (uint32_t i = count; i-- > 0;) kept[--starts[unsorted[i].cell]] = unsorted[i];
  q->start_count += cells + 1;
  q->kept_count += count;
  return fill_balls(q, rocks, kept) ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
}

/* A hull, on the stack. */
typedef struct hull_copy {
  float x[FIELD_MAX_HULL], y[FIELD_MAX_HULL], z[FIELD_MAX_HULL];
  convex_hull hull;
  convex_measure measure; /* where the hull has points */
  bool made;
} hull_copy;

/* part: of a scatter. */
static void make_hull(hull_copy* copy, const scene_layer* layer, uint32_t asset, const kept_part* part) {
  const scree_field* field = layer->given.field;
  copy->hull = (convex_hull){.x = copy->x, .y = copy->y, .z = copy->z};
  if (layer->given.scatter != NULL) {
    float scale;
    copy->hull.count = scree_rt_scatter_hull(layer->given.scatter, part->part, part->random, copy->x, copy->y, copy->z, &scale);
    copy->hull.scale = (double)scale;
  } else {
    copy->hull.count = scree_rt_field_hull(field, asset, copy->x, copy->y, copy->z);
    copy->hull.scale = field->cell_size / field->lattice_per_cell;
  }
  if (copy->hull.count > 0) copy->measure = scree_rt_convex_measure(&copy->hull);
  copy->made = true;
}

enum { HULLS_AT_HAND = 16 };

/* A rock of a later layer that looks for one that it meets. */
typedef struct seeker {
  const scene_layer* layer;
  const kept_part* parts; /* kept ones of all scatters */
  kept_part part;         /* its own, if it is of one */
  kept_rock rock;
  hull_copy hull;
  hull_copy others[HULLS_AT_HAND]; /* of rocks that were asked lately; neighbours often ask the same ones */
  const scene_layer* other_layers[HULLS_AT_HAND];
  uint32_t other_assets[HULLS_AT_HAND];
} seeker;

/* Whether the balls of a pair leave it open, and how deep they are in one another: less is deeper. */
static bool balls_meet(const seeker* s, const kept_rock* rock, double* depth) {
  double d2 = 0, apart = s->rock.radius + rock->radius;
  for (int a = 0; a < 3; ++a) {
    double d = rock->centroid[a] - s->rock.centroid[a];
    d2 += d * d;
  }
  *depth = d2 - apart * apart;
  return *depth <= 0;
}

static bool hulls_meet(seeker* s, const scene_layer* other, const kept_rock* rock) {
  if (!s->hull.made) make_hull(&s->hull, s->layer, s->rock.asset, &s->part);
  const uint32_t place = rock->asset % HULLS_AT_HAND;
  hull_copy* theirs = &s->others[place];
  if (s->other_layers[place] != other || s->other_assets[place] != rock->asset) {
    make_hull(theirs, other, rock->asset, other->given.scatter != NULL ? &s->parts[rock->asset] : NULL);
    s->other_layers[place] = other;
    s->other_assets[place] = rock->asset;
  }
  if (s->hull.hull.count == 0 || theirs->hull.count == 0) return false;
  for (int a = 0; a < 3; ++a) theirs->hull.at[a] = rock->home[a] - s->rock.home[a];
  return scree_rt_convex_meet_measured(&s->hull.hull, &s->hull.measure, &theirs->hull, &theirs->measure);
}

enum {
  MOST_OPEN = 32,
  FEW_ROCKS = 32 /* so few are looked at one by one */
};

/* Rocks whose balls meet the seeker's. The deepest is asked first, because one that meets is enough. */
typedef struct open_pairs {
  const kept_rock* rocks[MOST_OPEN];
  uint32_t count, deepest;
  double depth;
} open_pairs;

static bool settle(open_pairs* open, seeker* s, const scene_layer* other) {
  if (open->count == 0) return false;
  bool met = hulls_meet(s, other, open->rocks[open->deepest]);
  for (uint32_t i = 0; i < open->count && !met; ++i) met = i != open->deepest && hulls_meet(s, other, open->rocks[i]);
  open->count = 0;
  return met;
}

/* Asks the deepest alone. */
static bool settle_deepest(open_pairs* open, seeker* s, const scene_layer* other) {
  if (open->count == 0) return false;
  if (hulls_meet(s, other, open->rocks[open->deepest])) return true;
  open->rocks[open->deepest] = open->rocks[--open->count];
  open->deepest = 0;
  open->depth = INFINITY; /* whichever comes next goes before those that are left */
  return false;
}

/* Where and among which rocks of a layer a seeker looks: all in floats, a little too wide. */
typedef struct first_look {
  ball_arrays balls;
  vfloat x, y, z, radius;
} first_look;

static first_look begin_look(const scene_question* q, const seeker* s, const layer_rocks* rocks) {
  return (first_look){balls_of(q, rocks), v_set((float)(s->rock.centroid[0] - rocks->cell_low[0])),
                      v_set((float)(s->rock.centroid[1] - rocks->cell_low[1])),
                      v_set((float)(s->rock.centroid[2] - rocks->cell_low[2])),
                      v_set((float)(s->rock.radius * (1 + 1e-5) + 1e-6 * (s->rock.radius + rocks->cell_step)))};
}

/* Looks at rocks from .. end - 1; true when one of them is known to meet. */
static bool look_at(open_pairs* open, seeker* s, const scene_layer* other, const kept_rock* rocks, const first_look* look,
                    uint32_t from, uint32_t end) {
  for (uint32_t i = from; i < end; i += SIMD_WIDTH) {
    const vfloat dx = v_load(look->balls.x + i) - look->x, dy = v_load(look->balls.y + i) - look->y,
                 dz = v_load(look->balls.z + i) - look->z, apart = v_load(look->balls.radius + i) + look->radius;
    uint32_t bits = v_bits(dx * dx + dy * dy + dz * dz <= apart * apart);
    if (end - i < SIMD_WIDTH) bits &= (1u << (end - i)) - 1;
    for (; bits != 0; bits &= bits - 1) {
      const kept_rock* rock = &rocks[i + (uint32_t)__builtin_ctz(bits)];
      double depth;
      if (!balls_meet(s, rock, &depth)) continue;
      if (open->count == 0 || depth < open->depth) {
        open->deepest = open->count;
        open->depth = depth;
      }
      open->rocks[open->count++] = rock;
      if (open->count == MOST_OPEN && settle(open, s, other)) return true;
    }
  }
  return false;
}

/* How far a place relative to cell_low is from cell i along an axis. */
static double away_from_cell(const layer_rocks* rocks, uint32_t i, double at) {
  const double low = rocks->cell_step * i, high = low + rocks->cell_step;
  return at < low ? low - at : at > high ? at - high : 0;
}

/* Looks at the rocks in row (y, z) of a layer's cells that a seeker may reach. at: relative to cell_low. */
static inline bool look_along_row(const scene_question* q, const layer_rocks* rocks, uint32_t y, uint32_t z, const double at[3],
                                  double reach, const first_look* look, open_pairs* open, seeker* s, const scene_layer* layer) {
  const double away_y = away_from_cell(rocks, y, at[1]), away_z = away_from_cell(rocks, z, at[2]);
  const double left2 = reach * reach - away_z * away_z - away_y * away_y;
  if (left2 < 0) return false;
  const double half = sqrt(left2);
  const kept_rock* kept = (const kept_rock*)q->scratch->buffers[SCRATCH_KEPT].memory + rocks->kept_first;
  const uint32_t* starts = (const uint32_t*)q->scratch->buffers[SCRATCH_KEPT_STARTS].memory + rocks->start_first;
  const uint32_t* row = starts + (size_t)(z * rocks->cell_count[1] + y) * rocks->cell_count[0];
  const uint32_t from = row[cell_along(rocks, 0, at[0] - half)], end = row[cell_along(rocks, 0, at[0] + half) + 1];
  return look_at(open, s, layer, kept, look, from, end);
}

static bool meets_layer(const scene_question* q, seeker* s, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  open_pairs open;
  open.count = 0;
  const first_look look = begin_look(q, s, rocks);
  if (rocks->kept_count <= FEW_ROCKS) {
    const kept_rock* kept = (const kept_rock*)q->scratch->buffers[SCRATCH_KEPT].memory + rocks->kept_first;
    return look_at(&open, s, layer, kept, &look, 0, rocks->kept_count) || settle(&open, s, layer);
  }
  const double reach = (s->rock.radius + layer->rock_radius) * 1.000001 + rocks->cell_slack;
  double at[3];
  uint32_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    at[a] = s->rock.centroid[a] - rocks->cell_low[a];
    low[a] = cell_along(rocks, a, at[a] - reach);
    high[a] = cell_along(rocks, a, at[a] + reach);
  }
  /* First the row that the seeker stands in: it is likely to meet one of that, and then the others do not matter. */
  const uint32_t own_y = cell_along(rocks, 1, at[1]), own_z = cell_along(rocks, 2, at[2]);
  if (look_along_row(q, rocks, own_y, own_z, at, reach, &look, &open, s, layer) || settle_deepest(&open, s, layer)) return true;
  for (uint32_t z = low[2]; z <= high[2]; ++z)
    for (uint32_t y = low[1]; y <= high[1]; ++y)
      if ((y != own_y || z != own_z) && look_along_row(q, rocks, y, z, at, reach, &look, &open, s, layer)) return true;
  return settle(&open, s, layer);
}

/* The earlier layers that a layer may meet, and where. */
typedef struct other_layers {
  uint32_t layers[SCENE_MAX_LAYERS], count;
  bool mapped;
  near_map map; /* kinds: the first seven layers, and all others together */
} other_layers;

static uint8_t kind_of(uint32_t other) {
  return (uint8_t)(1u << (other < 7 ? other : 7));
}

/* Maps where rocks of the layer `index` could stand that reach the others. Where there are as many of theirs it would not pay.
 * Returns false when memory is short. */
static bool map_others(scene_question* q, uint32_t index, other_layers* others) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  double reach = INFINITY, kept = 0, origin[3];
  for (uint32_t i = 0; i < others->count; ++i) {
    reach = fmin(reach, layer->reach + q->scene->layers[others->layers[i]].rock_radius);
    kept += q->layers[others->layers[i]].kept_count;
  }
  others->mapped = kept <= 2 * (double)rocks->count;
  if (!others->mapped) return true;
  for (double many = 4; many <= 64 && many * kept < (double)rocks->count; many *= 4) reach *= 0.5; /* finer cells pay, too */
  for (int a = 0; a < 3; ++a) origin[a] = q->origin[a] - q->scene->base[a];
  if (!scree_rt_near_map_begin(&others->map, q->scratch, rocks->tight_low, rocks->tight_high, origin, reach,
                               512 + 8 * ((double)rocks->count + kept)))
    return false;
  const kept_rock* all = q->scratch->buffers[SCRATCH_KEPT].memory;
  for (uint32_t i = 0; i < others->count; ++i) {
    const layer_rocks* theirs = &q->layers[others->layers[i]];
    for (const kept_rock* rock = all + theirs->kept_first; rock < all + theirs->kept_first + theirs->kept_count; ++rock)
      if (ball_meets_box(rock->centroid, rock->radius, rocks->tight_low, rocks->tight_high))
        scree_rt_near_map_add(&others->map, rock->centroid, rock->radius + layer->reach, kind_of(i));
  }
  return true;
}

static bool meets_layer_near(const scene_question* q, seeker* s, uint32_t index) {
  const layer_rocks* rocks = &q->layers[index];
  return ball_meets_box(s->rock.centroid, s->rock.radius, rocks->tight_low, rocks->tight_high) && meets_layer(q, s, index);
}

static bool meets_others(const scene_question* q, seeker* s, const other_layers* others, uint8_t kinds) {
  for (uint32_t bits = kinds; bits != 0; bits &= bits - 1) {
    const uint32_t kind = (uint32_t)__builtin_ctz(bits), end = kind < 7 ? kind + 1 : others->count;
    for (uint32_t i = kind; i < end && i < others->count; ++i)
      if (meets_layer_near(q, s, others->layers[i])) return true;
  }
  return false;
}

/* Whether rock i, or any part of an instance, meets one of the others. What stands of a cliff is never dropped: it is there because
 * somebody put it there, and its parts hold air in which others may well lie. */
static bool is_dropped(const scene_question* q, seeker* s, const other_layers* others, uint8_t kinds, uint64_t i) {
  const uint32_t asset = q->instances[i].asset;
  if (s->layer->given.scatter != NULL && s->layer->given.scatter->is_cliff &&
      scatter_model_of(asset) < s->layer->given.scatter->variants[1])
    return false;
  if (s->layer->given.scatter == NULL) {
    s->rock = place_rock(s->layer, &q->ids[i], asset);
    s->hull.made = false;
    return meets_others(q, s, others, kinds);
  }
  for (uint32_t part = 0; part < scatter_parts(s->layer, asset); ++part) {
    s->rock = place_part(q, s->layer, i, part, &s->part);
    s->hull.made = false;
    if (meets_others(q, s, others, kinds)) return true;
  }
  return false;
}

/* Moves out the rocks of a layer that meet one of the others. */
static scree_result drop(scene_question* q, uint32_t index, other_layers* others) {
  layer_rocks* rocks = &q->layers[index];
  if (!map_others(q, index, others)) return SCREE_ERROR_OUT_OF_MEMORY;
  seeker s;
  s.layer = &q->scene->layers[index];
  s.parts = q->scratch->buffers[SCRATCH_KEPT_PARTS].memory;
  memset(s.other_layers, 0, sizeof s.other_layers);
  uint64_t end = rocks->first + rocks->count, kept = rocks->first;
  for (uint64_t i = rocks->first; i < end; ++i) {
    const uint8_t kinds = others->mapped ? near_map_kinds(&others->map, q->instances[i].position) : UINT8_MAX;
    if (kinds != 0 && is_dropped(q, &s, others, kinds, i)) continue;
    if (kept < i) {
      q->ids[kept] = q->ids[i];
      q->instances[kept] = q->instances[i];
    }
    ++kept;
  }
  rocks->count = kept - rocks->first;
  return SCREE_OK;
}

scree_result scree_rt_scene_keep(scene_question* q) {
  q->start_count = q->kept_count = q->ball_count = 0;
  q->part_count = 0;
  uint64_t filled = 0;
  for (uint32_t k = 0; k < q->scene->layer_count; ++k) {
    layer_rocks* rocks = &q->layers[k];
    if (!rocks->needed || rocks->count == 0) continue;
    other_layers others;
    others.count = 0;
    for (uint64_t rest = filled; rest != 0; rest &= rest - 1) {
      uint32_t j = (uint32_t)__builtin_ctzll(rest);
      bool apart = q->layers[j].kept_count == 0;
      for (int a = 0; a < 3; ++a)
        apart = apart || q->layers[j].tight_low[a] > rocks->tight_high[a] || q->layers[j].tight_high[a] < rocks->tight_low[a];
      if (!apart) others.layers[others.count++] = j;
    }
    scree_result result = others.count > 0 ? drop(q, k, &others) : SCREE_OK;
    if (result == SCREE_OK && rocks->wanted) result = fill_cells(q, k);
    if (result != SCREE_OK) return result;
    if (rocks->wanted) filled |= UINT64_C(1) << k;
  }
  return SCREE_OK;
}
