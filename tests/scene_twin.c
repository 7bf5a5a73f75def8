#include "scene_twin.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* after the five above */
#include <cmocka.h>

#include "convex.h"

static int compare_rocks(const void* a, const void* b) {
  const scree_id *p = &((const scree_rock*)a)->id, *q = &((const scree_rock*)b)->id;
  if (p->layer != q->layer) return p->layer < q->layer ? -1 : 1;
  for (int k = 2; k >= 0; --k)
    if (p->cube[k] != q->cube[k]) return p->cube[k] < q->cube[k] ? -1 : 1;
  return p->local < q->local ? -1 : p->local > q->local;
}

/* --- filters --------------------------------------------------------------------------------------------------------------- */

static double sample(const scree_filter* f, double i, double k) {
  double last_i = f->width - 1, last_k = f->depth - 1;
  uint32_t x = (uint32_t)(i < 0 ? 0 : i > last_i ? last_i : i), z = (uint32_t)(k < 0 ? 0 : k > last_k ? last_k : k);
  return (double)f->values[(size_t)z * f->width + x];
}

static double share(const scree_filter* f, const double at[3]) {
  double value = at[1], part;
  if (f->kind != SCREE_FILTER_ALTITUDE) {
    double u = (at[0] - f->centre[0]) / (double)f->spacing + (f->width - 1) * 0.5;
    double v = (at[2] - f->centre[2]) / (double)f->spacing + (f->depth - 1) * 0.5;
    u = fmin(fmax(u, 0), f->width - 1.0);
    v = fmin(fmax(v, 0), f->depth - 1.0);
    double i = fmin(floor(u), f->width - 2.0), k = fmin(floor(v), f->depth - 2.0);
    u -= i;
    v -= k;
    double a = sample(f, i, k), b = sample(f, i + 1, k), c = sample(f, i, k + 1), d = sample(f, i + 1, k + 1);
    if (f->kind == SCREE_FILTER_MASK) {
      part = (a * (1 - u) + b * u) * (1 - v) + (c * (1 - u) + d * u) * v;
      return f->inverted ? 1 - part : part;
    }
    double dx = ((b - a) * (1 - v) + (d - c) * v) / (double)f->spacing;
    double dz = ((c - a) * (1 - u) + (d - b) * u) / (double)f->spacing;
    value = atan(sqrt(dx * dx + dz * dz)) * 57.29577951308232;
  }
  double from = (double)f->from, to = (double)f->to, fade = (double)f->fade;
  part = value < from ? 1 - (from - value) / fade : value > to ? 1 - (value - to) / fade : 1;
  if (!(part > 0)) part = 0;
  return f->inverted ? 1 - part : part;
}

static bool passes(const twin_layer* layer, const twin_rock* rock) {
  double product = layer->given->density > 0 ? (double)layer->given->density : 1;
  for (uint32_t i = 0; i < layer->given->filter_count; ++i) product *= share(&layer->given->filters[i], rock->place);
  const scree_id* id = &rock->rock.id;
  const uint64_t seed = layer->models != NULL ? layer->models->seed : layer->given->field->seed;
  uint64_t hash =
      hash_corner(seed ^ UINT64_C(0xd1b54a32d192ed03), id->cube[0], layer->models != NULL ? 0 : id->cube[1], id->cube[2]);
  return (double)(hash_combine(hash, id->local) >> 11) / 9007199254740992.0 < product;
}

/* --- overlaps -------------------------------------------------------------------------------------------------------------- */

bool twin_hull(const twin_layer* layer, const twin_rock* rock, uint32_t part, const double from[3], float xyz[3][64],
               convex_hull* hull) {
  *hull = (convex_hull){.x = xyz[0], .y = xyz[1], .z = xyz[2]};
  if (layer->models == NULL) {
    const scree_field* field = layer->given->field;
    for (int a = 0; a < 3; ++a) hull->at[a] = (field->origin[a] - from[a]) + field->cell_size * (double)rock->cell[a];
    hull->count = part == 0 ? scree_rt_field_hull(field, rock->rock.asset, xyz[0], xyz[1], xyz[2]) : 0;
    hull->scale = field->cell_size / field->lattice_per_cell;
    return hull->count > 0;
  }
  const scree_scatter* s = layer->given->scatter;
  float points[64][3], turn[2], scale;
  if (scree_scatter_part(s, rock->rock.asset, part, points[0], 64, &hull->count) != SCREE_OK) return false;
  scree_scatter_turn(s, rock->random, turn, &scale);
  for (uint32_t i = 0; i < hull->count; ++i) {
    xyz[0][i] = turn[1] * points[i][0] + turn[0] * points[i][2];
    xyz[1][i] = points[i][1];
    xyz[2][i] = turn[1] * points[i][2] - turn[0] * points[i][0];
  }
  hull->scale = (double)scale;
  for (int a = 0; a < 3; ++a)
    hull->at[a] = (layer->models->origin[a] - from[a]) + s->unit * (double)rock->cell[a]; /* steps, see twin_scene */
  return true;
}

static double reach_of(const convex_hull* hull) {
  double most = 0;
  for (uint32_t i = 0; i < hull->count; ++i)
    most = fmax(most, hypot(hypot((double)hull->x[i], (double)hull->y[i]), (double)hull->z[i]) * hull->scale);
  return most * 1.001;
}

static bool hulls_meet(const twin_layer* la, const twin_rock* a, const twin_layer* lb, const twin_rock* b, const double base[3]) {
  double far2 = 0;
  for (int i = 0; i < 3; ++i) far2 += (b->place[i] - a->place[i]) * (b->place[i] - a->place[i]);
  if (far2 > 20 * 20) return false; /* nothing in these tests is so large */
  float xyz[2][3][64];
  convex_hull hulls[2];
  for (uint32_t i = 0; twin_hull(la, a, i, base, xyz[0], &hulls[0]); ++i) {
    const double reach = reach_of(&hulls[0]);
    const double home[3] = {hulls[0].at[0], hulls[0].at[1], hulls[0].at[2]};
    for (uint32_t k = 0; twin_hull(lb, b, k, base, xyz[1], &hulls[1]); ++k) {
      const double apart = reach + reach_of(&hulls[1]);
      if (far2 > apart * apart) continue;
      for (int axis = 0; axis < 3; ++axis) {
        hulls[0].at[axis] = 0;
        hulls[1].at[axis] -= home[axis];
      }
      if (scree_rt_convex_meet(&hulls[0], &hulls[1])) return true;
      for (int axis = 0; axis < 3; ++axis) hulls[0].at[axis] = home[axis];
    }
  }
  return false;
}

static bool meets_an_earlier(const scene_twin* twin, uint32_t k, const twin_rock* rock, const double base[3]) {
  for (uint32_t j = 0; j < k; ++j)
    for (uint64_t i = 0; i < twin->layers[j].count; ++i) {
      const twin_rock* other = &twin->layers[j].rocks[i];
      if (!other->dropped && hulls_meet(&twin->layers[k], rock, &twin->layers[j], other, base)) return true;
    }
  return false;
}

/* --- cells ----------------------------------------------------------------------------------------------------------------- */

static bool is_looked_at(const twin_layer* layer, const int64_t cell[3]) {
  for (int a = 0; a < 3; ++a)
    if (cell[a] < layer->low[a] || cell[a] >= layer->high[a]) return false;
  return true;
}

static size_t cell_index(const twin_layer* layer, const int64_t cell[3]) {
  size_t index = 0;
  assert_true(is_looked_at(layer, cell));
  for (int a = 2; a >= 0; --a) {
    index = index * (size_t)(layer->high[a] - layer->low[a]) + (size_t)(cell[a] - layer->low[a]);
  }
  return index;
}

static void find_full_cells(twin_layer* layer) {
  const scree_field* field = layer->given->field;
  size_t size = 1;
  for (int a = 0; a < 3; ++a) size *= (size_t)(layer->high[a] - layer->low[a]);
  layer->full = calloc(size + 1, 1);
  assert_non_null(layer->full);
  for (uint64_t i = 0; i < layer->count; ++i)
    if (!layer->rocks[i].dropped && layer->rocks[i].edit == SCREE_EDIT_NONE) ++layer->full[cell_index(layer, layer->rocks[i].cell)];
  int64_t c[3], n = layer->source->cells_per_cube;
  for (c[2] = layer->low[2]; c[2] < layer->high[2]; ++c[2])
    for (c[1] = layer->low[1]; c[1] < layer->high[1]; ++c[1])
      for (c[0] = layer->low[0]; c[0] < layer->high[0]; ++c[0]) {
        int32_t cube[3];
        uint32_t place[3];
        for (int a = 0; a < 3; ++a) {
          place[a] = (uint32_t)(((c[a] % n) + n) % n);
          cube[a] = (int32_t)((c[a] - place[a]) / n);
        }
        uint32_t code = cube_code(field->seed, cube[0], cube[1], cube[2]);
        uint32_t cell = scree_rt_lattice_cell((uint32_t)n, code, place[0], place[1], place[2]);
        uint8_t* full = &layer->full[cell_index(layer, c)];
        *full = *full == layer->source->cell_first[cell + 1] - layer->source->cell_first[cell];
      }
}

static bool is_buried(const twin_layer* layer, const twin_rock* rock) {
  int64_t b = layer->source->rocks[rock->rock.asset].burial, c[3];
  if (b < 1 || b >= SCREE_BURIAL_NEVER) return false;
  for (c[2] = rock->cell[2] - b; c[2] <= rock->cell[2] + b; ++c[2])
    for (c[1] = rock->cell[1] - b; c[1] <= rock->cell[1] + b; ++c[1])
      for (c[0] = rock->cell[0] - b; c[0] <= rock->cell[0] + b; ++c[0])
        if (!is_looked_at(layer, c) || !layer->full[cell_index(layer, c)]) return false;
  return true;
}

static void find_rocks(twin_layer* layer, const double middle[3], double reach, const double origin[3]) {
  const scree_field* field = layer->given->field;
  scree_query_desc query = {.field = field,
                            .support = layer->given->support,
                            .threshold = layer->given->threshold,
                            .shell_depth = layer->given->shell_depth,
                            .flags = layer->given->shell_depth > 0 ? SCREE_QUERY_SHELL : 0};
  memcpy(query.origin, origin, sizeof query.origin);
  for (int a = 0; a < 3; ++a) {
    layer->low[a] = (int64_t)floor((middle[a] - reach - field->origin[a]) / field->cell_size);
    layer->high[a] = (int64_t)ceil((middle[a] + reach - field->origin[a]) / field->cell_size);
  }
  found_rocks found = twin_query(&query, layer->source, layer->low, layer->high);
  layer->rocks = calloc(found.count + 1, sizeof *layer->rocks);
  assert_non_null(layer->rocks);
  for (uint64_t i = 0; i < found.count; ++i) {
    twin_rock* rock = &layer->rocks[layer->count++];
    *rock = (twin_rock){.rock = {.asset = found.rocks[i].instance.asset, .id = found.rocks[i].id}};
    memcpy(rock->rock.position, found.rocks[i].instance.position, sizeof rock->rock.position);
    uint32_t cell = rock->rock.id.local / layer->source->max_rocks_per_cell, n = layer->source->cells_per_cube;
    for (int a = 0; a < 3; ++a) {
      rock->cell[a] = (int64_t)rock->rock.id.cube[a] * n + cell % n;
      rock->place[a] = field->origin[a] + field->cell_size * (double)rock->cell[a];
      cell /= n;
    }
  }
  found_free(&found);
}

/* cell: of an instance, its steps. */
static void find_instances(twin_layer* layer, const double middle[3], double reach, const double origin[3]) {
  const scree_scatter* s = layer->given->scatter;
  double low[3], high[3];
  int32_t first[2], end[2];
  scree_support_bounds(layer->given->support, low, high);
  for (int i = 0; i < 2; ++i) {
    const double side = s->unit * 4096, from = layer->models->origin[2 * i];
    first[i] = (int32_t)floor((fmax(low[2 * i], middle[2 * i] - reach) - from) / side);
    end[i] = (int32_t)floor((fmin(high[2 * i], middle[2 * i] + reach) - from) / side) + 1;
  }
  twin_stands found = twin_scatter(s, layer->models, layer->given->support, first, end, fmin(high[1], middle[1] + reach) + 0.1,
                                   fmax(low[1], middle[1] - reach) - 0.1);
  layer->rocks = calloc(found.count + 1, sizeof *layer->rocks);
  assert_non_null(layer->rocks);
  for (uint64_t i = 0; i < found.count; ++i) {
    twin_rock* rock = &layer->rocks[layer->count++];
    *rock = (twin_rock){.rock = {.asset = found.stands[i].model, .id = found.stands[i].id}, .random = found.stands[i].random};
    for (int a = 0; a < 3; ++a) {
      const double away = s->unit * (double)found.stands[i].steps[a];
      rock->cell[a] = found.stands[i].steps[a];
      rock->place[a] = layer->models->origin[a] + away;
      rock->rock.position[a] = (float)((layer->models->origin[a] - origin[a]) + away);
    }
  }
  free(found.stands);
}

scene_twin twin_scene(const scree_scene_desc* desc, const field_source* const* sources, const scree_scatter_desc* const* scatters,
                      const twin_edit* edits, uint32_t edit_count, const double middle[3], double reach, const double origin[3]) {
  scene_twin twin = {.count = desc->layer_count};
  bool keyed = false;
  for (uint32_t k = 0; k < desc->layer_count; ++k) keyed = keyed || desc->layers[k].key != 0;
  for (uint32_t k = 0; k < desc->layer_count; ++k) {
    twin_layer* layer = &twin.layers[k];
    layer->given = &desc->layers[k];
    layer->source = sources[k];
    if (layer->given->scatter != NULL) {
      layer->models = scatters[k];
      find_instances(layer, middle, reach, origin);
    } else {
      find_rocks(layer, middle, reach, origin);
    }
    uint64_t kept = 0;
    for (uint64_t i = 0; i < layer->count; ++i) {
      twin_rock rock = layer->rocks[i];
      rock.rock.id.layer = (uint16_t)(keyed ? layer->given->key : k);
      for (uint32_t e = 0; e < edit_count; ++e)
        if (memcmp(&edits[e].id, &rock.rock.id, sizeof rock.rock.id) == 0) rock.edit = edits[e].edit;
      if (passes(layer, &rock)) layer->rocks[kept++] = rock;
    }
    layer->count = kept;
  }
  const double* base = twin.layers[0].models != NULL ? twin.layers[0].models->origin : desc->layers[0].field->origin;
  for (uint32_t k = 1; k < twin.count; ++k)
    for (uint64_t i = 0; i < twin.layers[k].count; ++i)
      twin.layers[k].rocks[i].dropped = meets_an_earlier(&twin, k, &twin.layers[k].rocks[i], base);
  for (uint32_t k = 0; k < twin.count; ++k)
    if (twin.layers[k].models == NULL) find_full_cells(&twin.layers[k]);
  return twin;
}

void twin_scene_free(scene_twin* twin) {
  for (uint32_t k = 0; k < twin->count; ++k) {
    free(twin->layers[k].rocks);
    free(twin->layers[k].full);
  }
}

scene_rocks twin_answer(const scene_twin* twin, const scree_scene_query_desc* d) {
  scene_rocks out = {NULL, 0};
  bool everywhere = true, visible = (d->flags & SCREE_SCENE_VISIBLE) != 0;
  for (int a = 0; a < 3; ++a) everywhere = everywhere && d->min[a] == 0 && d->max[a] == 0;
  for (uint32_t k = 0; k < twin->count; ++k) {
    const twin_layer* layer = &twin->layers[k];
    if (d->layers != 0 && (d->layers >> k & 1) == 0) continue;
    out.rocks = realloc(out.rocks, (out.count + layer->count + 1) * sizeof *out.rocks);
    assert_non_null(out.rocks);
    for (uint64_t i = 0; i < layer->count; ++i) {
      const twin_rock* rock = &layer->rocks[i];
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        if (layer->models != NULL) {
          inside = inside && rock->place[a] >= d->min[a] && rock->place[a] < d->max[a];
          continue;
        }
        double centre = layer->given->field->cell_size * (double)rock->cell[a], from = layer->given->field->origin[a];
        inside = inside && centre >= d->min[a] - from && centre < d->max[a] - from;
      }
      if (!(inside || everywhere) || rock->dropped || rock->edit == SCREE_EDIT_REMOVE) continue;
      if (visible && (rock->edit == SCREE_EDIT_HIDE || (layer->models == NULL && is_buried(layer, rock)))) continue;
      out.rocks[out.count++] = rock->rock;
    }
  }
  scene_rocks_sort(&out);
  return out;
}

scene_rocks ask_scene(const scree_scene_query_desc* desc, scree_scratch* scratch) {
  uint64_t count = 0, filled = 0;
  assert_int_equal(scree_scene_count(desc, scratch, &count), SCREE_OK);
  scene_rocks out = {malloc((size_t)(count + 1) * sizeof *out.rocks), count};
  assert_non_null(out.rocks);
  assert_int_equal(scree_scene_fill(desc, scratch, out.rocks, count, &filled), SCREE_OK);
  assert_int_equal(filled, count);
  scene_rocks_sort(&out);
  return out;
}

void scene_rocks_sort(scene_rocks* rocks) {
  if (rocks->count > 0) qsort(rocks->rocks, rocks->count, sizeof *rocks->rocks, compare_rocks);
}

void scene_rocks_join(scene_rocks* a, const scree_rock* rocks, uint64_t count) {
  if (count == 0) return;
  a->rocks = realloc(a->rocks, (a->count + count) * sizeof *a->rocks);
  assert_non_null(a->rocks);
  memcpy(a->rocks + a->count, rocks, count * sizeof *rocks);
  a->count += count;
}

void scene_rocks_free(scene_rocks* rocks) {
  free(rocks->rocks);
  *rocks = (scene_rocks){NULL, 0};
}

uint64_t scene_rocks_missing(const scene_rocks* a, const scene_rocks* b) {
  uint64_t missing = 0, i = 0;
  for (uint64_t k = 0; k < b->count; ++k) {
    while (i < a->count && compare_rocks(&a->rocks[i], &b->rocks[k]) < 0) ++i;
    missing += i == a->count || compare_rocks(&a->rocks[i], &b->rocks[k]) != 0;
  }
  return missing;
}

void assert_scene_rocks_equal(const scene_rocks* expected, const scene_rocks* found) {
  uint64_t missing = scene_rocks_missing(found, expected), extra = scene_rocks_missing(expected, found);
  if (missing != 0 || extra != 0)
    fail_msg("of %llu rocks %llu are missing, and %llu are there that should not be", (unsigned long long)expected->count,
             (unsigned long long)missing, (unsigned long long)extra);
  assert_int_equal(expected->count, found->count);
  for (uint64_t i = 0; i < expected->count; ++i) assert_memory_equal(&expected->rocks[i], &found->rocks[i], sizeof *found->rocks);
}
