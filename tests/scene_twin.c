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
  const scree_field* field = layer->given->field;
  double product = layer->given->density > 0 ? (double)layer->given->density : 1, at[3];
  for (int a = 0; a < 3; ++a) at[a] = field->origin[a] + field->cell_size * (double)rock->cell[a];
  for (uint32_t i = 0; i < layer->given->filter_count; ++i) product *= share(&layer->given->filters[i], at);
  const scree_id* id = &rock->rock.id;
  uint64_t hash = hash_corner(field->seed ^ UINT64_C(0xd1b54a32d192ed03), id->cube[0], id->cube[1], id->cube[2]);
  return (double)(hash_combine(hash, id->local) >> 11) / 9007199254740992.0 < product;
}

/* --- overlaps -------------------------------------------------------------------------------------------------------------- */

static void home_of(const twin_layer* layer, const twin_rock* rock, const double base[3], double home[3]) {
  const scree_field* field = layer->given->field;
  for (int a = 0; a < 3; ++a) home[a] = (field->origin[a] - base[a]) + field->cell_size * (double)rock->cell[a];
}

static bool hulls_meet(const twin_layer* la, const twin_rock* a, const twin_layer* lb, const twin_rock* b, const double base[3]) {
  double home_a[3], home_b[3], far2 = 0;
  home_of(la, a, base, home_a);
  home_of(lb, b, base, home_b);
  for (int i = 0; i < 3; ++i) far2 += (home_b[i] - home_a[i]) * (home_b[i] - home_a[i]);
  double most = 3 * (la->given->field->cell_size + lb->given->field->cell_size);
  if (far2 > most * most) return false; /* hulls reach 1.5 cells at most: twice that is far */
  float xyz[2][3][FIELD_MAX_HULL];
  convex_hull hulls[2] = {{.x = xyz[0][0], .y = xyz[0][1], .z = xyz[0][2]}, {.x = xyz[1][0], .y = xyz[1][1], .z = xyz[1][2]}};
  const scree_field* fields[2] = {la->given->field, lb->given->field};
  const uint32_t assets[2] = {a->rock.asset, b->rock.asset};
  for (int k = 0; k < 2; ++k) {
    hulls[k].count = scree_rt_field_hull(fields[k], assets[k], xyz[k][0], xyz[k][1], xyz[k][2]);
    if (hulls[k].count == 0) return false;
    hulls[k].scale = fields[k]->cell_size / fields[k]->lattice_per_cell;
  }
  for (int i = 0; i < 3; ++i) hulls[1].at[i] = home_b[i] - home_a[i];
  return scree_rt_convex_meet(&hulls[0], &hulls[1]);
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

scene_twin twin_scene(const scree_scene_desc* desc, const field_source* const* sources, const twin_edit* edits, uint32_t edit_count,
                      const double middle[3], double reach, const double origin[3]) {
  scene_twin twin = {.count = desc->layer_count};
  bool keyed = false;
  for (uint32_t k = 0; k < desc->layer_count; ++k) keyed = keyed || desc->layers[k].key != 0;
  for (uint32_t k = 0; k < desc->layer_count; ++k) {
    twin_layer* layer = &twin.layers[k];
    layer->given = &desc->layers[k];
    layer->source = sources[k];
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
      twin_rock rock = {.rock = {.asset = found.rocks[i].instance.asset, .id = found.rocks[i].id}};
      memcpy(rock.rock.position, found.rocks[i].instance.position, sizeof rock.rock.position);
      rock.rock.id.layer = (uint16_t)(keyed ? layer->given->key : k);
      uint32_t cell = rock.rock.id.local / layer->source->max_rocks_per_cell, n = layer->source->cells_per_cube;
      for (int a = 0; a < 3; ++a) {
        rock.cell[a] = (int64_t)rock.rock.id.cube[a] * n + cell % n;
        cell /= n;
      }
      for (uint32_t e = 0; e < edit_count; ++e)
        if (memcmp(&edits[e].id, &rock.rock.id, sizeof rock.rock.id) == 0) rock.edit = edits[e].edit;
      if (passes(layer, &rock)) layer->rocks[layer->count++] = rock;
    }
    found_free(&found);
  }
  for (uint32_t k = 1; k < twin.count; ++k)
    for (uint64_t i = 0; i < twin.layers[k].count; ++i)
      twin.layers[k].rocks[i].dropped = meets_an_earlier(&twin, k, &twin.layers[k].rocks[i], desc->layers[0].field->origin);
  for (uint32_t k = 0; k < twin.count; ++k) find_full_cells(&twin.layers[k]);
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
        double centre = layer->given->field->cell_size * (double)rock->cell[a], from = layer->given->field->origin[a];
        inside = inside && centre >= d->min[a] - from && centre < d->max[a] - from;
      }
      if (!(inside || everywhere) || rock->dropped || rock->edit == SCREE_EDIT_REMOVE) continue;
      if (visible && (rock->edit == SCREE_EDIT_HIDE || is_buried(layer, rock))) continue;
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
