/* What nobody can see: rocks hidden by hide, and rocks whose neighbours all exist as far as their burial says.
 *
 *   cells of the box, a byte each          rows of bits, one a cell                 eroded once, twice, three times
 *   (cell_grid: FULL where all of   -->    1 = all of its rocks exist        -->    1 = so do those of the cells up to 1, 2, 3
 *   a cell's rocks exist)                                                           away, corners included
 *
 * The box is the one that is asked for, grown by the largest burial, so that nothing beyond it can matter.
 *
 * Rocks that lie so deep under the surface that all their neighbours are there, whatever those are, are not even looked for: the
 * query notes their cells as full and goes on. So thick supports cost little more than shells. */
#include <math.h>
#include <string.h>

#include "query_kernel.h"
#include "scene_layers.h"

enum { MOST_EROSIONS = SCREE_BURIAL_NEVER - 1 };

double scree_rt_scene_floor(const scene_layer* layer, const int64_t low[3], const int64_t high[3]) {
  const scree_field* field = layer->given.field;
  const scree_support* support = layer->given.support;
  double stray2 = 0, largest = support->magnitude;
  for (int a = 0; a < 3; ++a) {
    double stray = (double)field->centroid_max[a] - (double)field->centroid_min[a], base = field->origin[a] - support->origin[a];
    double from = fabs(base + field->cell_size * (double)low[a]), to = fabs(base + field->cell_size * (double)high[a]);
    stray2 += stray * stray;
    if (from > largest) largest = from;
    if (to > largest) largest = to;
  }
  double cells = field->deepest_burial * 1.7320508075688774, level = layer->level_low < 0 ? -layer->level_low : 0;
  double rounding = (largest + layer->reach) * 2e-5;
  return layer->lipschitz * ((field->cell_size * cells + sqrt(stray2)) * 1.0001 + rounding) + level + 2 * layer->doubt;
}

/* Marks the cells of the grid's cubes in which the field has no rock: they are full. */
static void mark_empty_cells(const scree_field* field, const cell_grid* grid) {
  int64_t n = field->cells_per_cube, cube[3], low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    low[a] = grid->low[a] / n - (grid->low[a] % n < 0);
    high[a] = (grid->high[a] - 1) / n - ((grid->high[a] - 1) % n < 0) + 1;
  }
  for (cube[2] = low[2]; cube[2] < high[2]; ++cube[2])
    for (cube[1] = low[1]; cube[1] < high[1]; ++cube[1])
      for (cube[0] = low[0]; cube[0] < high[0]; ++cube[0]) {
        uint32_t code = cube_code(field->seed, (int32_t)cube[0], (int32_t)cube[1], (int32_t)cube[2]);
        const uint8_t* counts = field->cell_counts + code * (size_t)(n * n * n);
        int64_t c[3], i = 0;
        for (c[2] = cube[2] * n; c[2] < (cube[2] + 1) * n; ++c[2])
          for (c[1] = cube[1] * n; c[1] < (cube[1] + 1) * n; ++c[1])
            for (c[0] = cube[0] * n; c[0] < (cube[0] + 1) * n; ++c[0], ++i)
              if (counts[i] == 0 && c[0] >= grid->low[0] && c[0] < grid->high[0] && c[1] >= grid->low[1] && c[1] < grid->high[1] &&
                  c[2] >= grid->low[2] && c[2] < grid->high[2])
                *grid_cell(grid, c) = SCREE_CELL_FULL;
      }
}

scree_result scree_rt_scene_make_grid(scree_scratch* scratch, const int64_t low[3], const int64_t high[3], cell_grid* grid) {
  size_t size[3];
  for (int a = 0; a < 3; ++a) {
    grid->low[a] = low[a];
    grid->high[a] = high[a];
    size[a] = (size_t)(high[a] - low[a]);
  }
  grid->row = (size[0] + 7) / 8 * 8;
  grid->slice = grid->row * size[1];
  grid->cells = scree_rt_scratch_reserve(scratch, SCRATCH_CELLS, grid->slice, size[2]);
  if (grid->cells == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  memset(grid->cells, 0, grid->slice * size[2]);
  return SCREE_OK;
}

/* Rows of bits: `words` of a row, `rows` of a slice, `slices`. */
typedef struct bit_box {
  size_t words, rows, slices;
} bit_box;

static void pack_rows(const cell_grid* grid, bit_box box, uint64_t* bits) {
  const uint8_t* row = grid->cells;
  for (size_t i = 0; i < box.rows * box.slices; ++i, row += grid->row, bits += box.words) {
    memset(bits, 0, box.words * sizeof *bits);
    for (size_t x = 0; x < grid->row; x += 8) {
      uint64_t eight;
      memcpy(&eight, row + x, sizeof eight);
      eight = eight >> 7 & UINT64_C(0x0101010101010101); /* FULL has this bit, no count does */
      bits[x / 64] |= (eight * UINT64_C(0x0102040810204080) >> 56) << (x % 64);
    }
  }
}

/* out: cells that are set in `in` together with their two neighbours along an axis; beyond the box nothing is set. */
static void erode_x(const uint64_t* in, bit_box box, uint64_t* out) {
  for (size_t i = 0; i < box.rows * box.slices; ++i, in += box.words, out += box.words) {
    uint64_t before = 0;
    for (size_t k = 0; k < box.words; ++k) {
      uint64_t word = in[k], after = k + 1 < box.words ? in[k + 1] : 0;
      out[k] = word & (word << 1 | before >> 63) & (word >> 1 | after << 63);
      before = word;
    }
  }
}

/* The same along y or z, where neighbours are `step` words apart, in parts of `size` words. */
static void erode_along(const uint64_t* in, size_t step, size_t size, size_t parts, uint64_t* out) {
  for (size_t p = 0; p < parts; ++p, in += size, out += size) {
    if (size < 3 * step) {
      memset(out, 0, size * sizeof *out);
      continue;
    }
    memset(out, 0, step * sizeof *out);
    memset(out + size - step, 0, step * sizeof *out);
    for (size_t i = step; i < size - step; ++i) out[i] = in[i] & in[i - step] & in[i + step];
  }
}

/* Where the cells of a cube are in the grid and in rows of bits, from the cube's first cell on. Rocks come cube by cube, so that
 * little is left to do for each. */
typedef struct cell_steps {
  const scree_field* field;
  const cell_grid* grid;
  bit_box box;
  uint32_t byte_of[FIELD_MAX_CELLS * FIELD_MAX_CELLS * FIELD_MAX_CELLS],
      bit_of[FIELD_MAX_CELLS * FIELD_MAX_CELLS * FIELD_MAX_CELLS];
  int32_t cube[3];
  ptrdiff_t first_byte, first_bit; /* of the cube's cell (0, 0, 0), which may lie beside the grid */
} cell_steps;

static void move_to(cell_steps* s, const int32_t cube[3]) {
  ptrdiff_t at[3];
  for (int a = 0; a < 3; ++a) {
    s->cube[a] = cube[a];
    at[a] = (ptrdiff_t)((int64_t)cube[a] * s->field->cells_per_cube - s->grid->low[a]);
  }
  s->first_byte = at[0] + at[1] * (ptrdiff_t)s->grid->row + at[2] * (ptrdiff_t)s->grid->slice;
  s->first_bit = at[0] + (at[1] + at[2] * (ptrdiff_t)s->box.rows) * (ptrdiff_t)(s->box.words * 64);
}

static inline void step_to(cell_steps* s, const scree_id* id) {
  if (s->cube[0] != id->cube[0] || s->cube[1] != id->cube[1] || s->cube[2] != id->cube[2]) move_to(s, id->cube);
}

static void begin_steps(cell_steps* s, const scree_field* field, const cell_grid* grid, bit_box box) {
  uint32_t n = field->cells_per_cube, row = (uint32_t)(box.words * 64);
  s->field = field;
  s->grid = grid;
  s->box = box;
  for (uint32_t i = 0; i < n * n * n; ++i) {
    const uint8_t* p = field->cell_places[i];
    s->byte_of[i] = p[0] + p[1] * (uint32_t)grid->row + p[2] * (uint32_t)grid->slice;
    s->bit_of[i] = p[0] + (p[1] + p[2] * (uint32_t)box.rows) * row;
  }
  const int32_t anywhere[3] = {0, 0, 0};
  move_to(s, anywhere);
}

scree_result scree_rt_scene_cull(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  const scree_field* field = layer->given.field;
  layer_rocks* rocks = &q->layers[index];
  const cell_grid* grid = &q->grid;
  bit_box box = {(grid->row + 63) / 64, (size_t)(grid->high[1] - grid->low[1]), (size_t)(grid->high[2] - grid->low[2])};
  size_t size = box.words * box.rows * box.slices;
  uint64_t* levels = scree_rt_scratch_reserve(q->scratch, SCRATCH_ERODED, size * (field->deepest_burial + 2), sizeof *levels);
  if (levels == NULL) return SCREE_ERROR_OUT_OF_MEMORY;

  cell_steps steps;
  begin_steps(&steps, field, grid, box);
  bool edited = scree_rt_scene_edited(q, index, grid->low, grid->high);
  uint64_t end = rocks->first + rocks->count;
  for (uint64_t i = rocks->first; i < end; ++i) {
    scree_id id = q->ids[i];
    id.layer = layer->given.key;
    if (edited && scree_edits_get(q->edits, &id) != SCREE_EDIT_NONE) continue;
    step_to(&steps, &id);
    grid_add(grid->cells + steps.first_byte + steps.byte_of[field_cell_of(field, id.local)],
             field->hidings[q->instances[i].asset].siblings);
  }
  if (field->cell_counts != NULL) mark_empty_cells(field, grid);

  /* Level b starts at levels + (b - 1) * size; behind them there are two for what lies between. */
  uint64_t *first = levels + size * field->deepest_burial, *second = first + size;
  pack_rows(grid, box, first);
  const uint64_t* from = first;
  for (uint32_t b = 1; b <= field->deepest_burial; ++b) {
    uint64_t* level = levels + size * (b - 1);
    erode_x(from, box, level);
    erode_along(level, box.words, box.words * box.rows, box.slices, second);
    erode_along(second, box.words * box.rows, size, 1, level);
    from = level;
  }

  uint64_t kept = rocks->first;
  for (uint64_t i = rocks->first; i < end; ++i) {
    const scree_id* id = &q->ids[i];
    uint32_t burial = field->hidings[q->instances[i].asset].burial;
    step_to(&steps, id);
    size_t bit = (size_t)(steps.first_bit + steps.bit_of[field_cell_of(field, id->local)]);
    if (burial < SCREE_BURIAL_NEVER && (levels[size * (burial - 1) + bit / 64] >> (bit % 64) & 1)) continue;
    q->ids[kept] = *id;
    q->instances[kept++] = q->instances[i];
  }
  rocks->count = kept - rocks->first;
  return SCREE_OK;
}
