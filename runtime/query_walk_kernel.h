/* The walk of a query through space, as static functions: included by each kernel and compiled for its target.
 * Based on: the octree culling of implicit surfaces with Lipschitz bounds (Hart, Sphere Tracing, 1996; Duff, Interval Arithmetic
 * and Recursive Subdivision for Implicit Functions, 1992: programs pruned part of space by part of space).
 *
 *   octree over cubes --> cube --> 8 blocks of its cells --> single rocks, 64 at a time
 *
 * On every level the support's distance at the middle of a part bounds it everywhere in the part. A part is out, or deep below the
 * shell, or all in it (bulk), or has to be split (straddling). All bounds allow for rounding, so the walk finds what testing each
 * rock by itself would find, to the bit. */
#ifndef SCREE_QUERY_WALK_KERNEL_H
#define SCREE_QUERY_WALK_KERNEL_H

#include <math.h>

#include "query_kernel.h"
#include "support_kernel.h"

enum { PARTS = 8, ARENA_OPS = 16384 };

typedef struct program_view {
  const uint16_t* ops;
  uint32_t length;
} program_view;

typedef struct walk {
  query_run* run;
  const scree_field* field;
  const support_op* ops;
  int64_t n; /* cells per cube */
  uint64_t count;
  float values[SUPPORT_MAX_STACK][SUPPORT_BATCH];
  float low[SUPPORT_MAX_STACK][PARTS], high[SUPPORT_MAX_STACK][PARTS]; /* bounds of operations over parts */
  /* Bit p: what the first or second side of this operation is does not matter in part p. */
  uint8_t first_idle[SUPPORT_MAX_OPS], second_idle[SUPPORT_MAX_OPS];
  uint16_t arena[ARENA_OPS]; /* pruned programs, a stack */
  uint32_t arena_used;
} walk;

/* 8 balls, and after bound_parts what the support's distance is there. Bit p of a mask speaks of part p. */
typedef struct parts {
  float x[PARTS], y[PARTS], z[PARTS], radius[PARTS];
  uint32_t bulk, straddling, deep;
  uint32_t prunable; /* parts where some operation is idle */
} parts;

/* A cube that is looked at. */
typedef struct cube_view {
  int32_t at[3];
  bool border;                     /* not all of its cells belong to the query */
  uint8_t low[3], high[3];         /* which do */
  const float *test[3], *place[3]; /* centres of cells along each axis, 8 each: in the support's space, and as delivered */
  const field_tile* tile;
  tile_slots slots;
} cube_view;

/* --- bounds ---------------------------------------------------------------------------------------------------------------- */

/* How fast a mesh's distance changes in each part: less than anywhere, where a part is small and the surface smooth. */
static void mesh_slopes(const support_op* op, const parts* p, float slopes[PARTS]) {
  const support_mesh* g = op->mesh.grid;
  const float small = op->mesh.frame.scale * g->step * (MESH_BRICK * 0.999f);
  for (int i = 0; i < PARTS; i += SIMD_WIDTH) {
    vpoint q = into_frame(&op->mesh.frame, (vpoint){v_load(p->x + i), v_load(p->y + i), v_load(p->z + i)});
    const vfloat at[3] = {q.x, q.y, q.z};
    vint index = v_set_int(0);
    for (int a = 2; a >= 0; --a) {
      vfloat cell = (at[a] - v_set(g->low[a])) * v_set(g->inverse_step);
      vint brick = v_truncate(v_clamp(cell, v_set(0), v_set((float)(g->size[a] - 2)))) / MESH_BRICK;
      index = index * v_set_int((int32_t)g->bricks[a]) + brick;
    }
    vfloat near = v_gather(g->brick_lipschitz, index), radius = v_load(p->radius + i);
    v_store(slopes + i, v_select(radius <= v_set(small), near, v_set(g->lipschitz)));
  }
}

static void bound_leaf(walk* w, const support_op* op, const parts* p, float* low, float* high) {
  const query_run* run = w->run;
  float value[PARTS];
  evaluate_leaf(op, p->x, p->y, p->z, value, PARTS, false);
  float top = (op->flipped ? -run->relevant_low : run->relevant_high) + op->slack_high;
  float bottom = (op->flipped ? -run->relevant_high : run->relevant_low) - op->slack_low;
  const vfloat infinite = v_set(INFINITY);
  float slopes[PARTS];
  if (op->kind == OP_MESH) {
    mesh_slopes(op, p, slopes);
  } else {
    for (int i = 0; i < PARTS; i += SIMD_WIDTH) v_store(slopes + i, v_set(op->lipschitz));
  }
  for (int i = 0; i < PARTS; i += SIMD_WIDTH) {
    vfloat slope = v_load(slopes + i);
    vfloat reach = (v_load(p->radius + i) * v_set(1.00001f) + v_set(run->margin)) * slope + v_set(op->doubt);
    vfloat l = v_load(value + i) - reach, h = v_load(value + i) + reach;
    vint above = l > v_set(top), below = h < v_set(bottom);
    v_store(low + i, v_select(above, infinite, v_select(below, -infinite, l)));
    v_store(high + i, v_select(above, infinite, v_select(below, -infinite, h)));
  }
}

static void bound_noise(walk* w, const support_op* op, const parts* p, float* low, float* high) {
  const float margin = w->run->margin * (op->lipschitz > 1 ? op->lipschitz : 1) + op->noise.amplitude * 1e-5f;
  for (int i = 0; i < PARTS; i += SIMD_WIDTH) {
    vpoint middle = {v_load(p->x + i), v_load(p->y + i), v_load(p->z + i)};
    vfloat least, most;
    noise_bounds(op, middle, v_load(p->radius + i) * v_set(1.00001f), margin, &least, &most);
    /* The sum is rounded; where the child is decided it stays infinite. */
    v_store(low + i, v_load(low + i) + least - v_set(w->run->margin));
    v_store(high + i, v_load(high + i) + most + v_set(w->run->margin));
  }
}

static void bound_pair(walk* w, const support_op* op, uint32_t at, uint32_t top) {
  float *al = w->low[top], *ah = w->high[top];
  const float *bl = w->low[top + 1], *bh = w->high[top + 1];
  uint32_t first = 0, second = 0;
  for (int i = 0; i < PARTS; i += SIMD_WIDTH) {
    vfloat a0 = v_load(al + i), a1 = v_load(ah + i), b0 = v_load(bl + i), b1 = v_load(bh + i), low, high;
    vint first_idle, second_idle;
    if (op->kind == OP_UNION) {
      first_idle = a0 >= b1;
      second_idle = b0 >= a1;
      low = v_min(a0, b0);
      high = v_min(a1, b1);
    } else if (op->kind == OP_SMOOTH_UNION) {
      vfloat apart = v_set(op->smooth.blend * 1.00001f);
      first_idle = a0 >= b1 + apart;
      second_idle = b0 >= a1 + apart;
      low = smooth_min(a0, b0, op->smooth.blend, op->smooth.inverse_blend);
      high = smooth_min(a1, b1, op->smooth.blend, op->smooth.inverse_blend);
    } else {
      if (op->kind == OP_DIFFERENCE) {
        vfloat swap = -b0;
        b0 = -b1;
        b1 = swap;
      }
      first_idle = a1 <= b0;
      second_idle = b1 <= a0;
      low = v_max(a0, b0);
      high = v_max(a1, b1);
    }
    v_store(al + i, low);
    v_store(ah + i, high);
    first |= v_bits(first_idle) << i;
    second |= v_bits(second_idle) << i;
  }
  w->second_idle[at] = (uint8_t)second;
  w->first_idle[at] = (uint8_t)(first & ~second);
}

/* Bounds the program's value in each part and sorts the parts; `lanes` has the parts that are asked about. */
static void bound_parts(walk* w, program_view program, parts* p, uint32_t lanes) {
  const query_run* run = w->run;
  uint32_t top = 0;
  p->prunable = 0;
  for (uint32_t i = 0; i < program.length; ++i) {
    const support_op* op = &w->ops[program.ops[i]];
    if (op_is_leaf(op->kind)) {
      bound_leaf(w, op, p, w->low[top], w->high[top]);
      ++top;
    } else if (op->kind == OP_NOISE) {
      bound_noise(w, op, p, w->low[top - 1], w->high[top - 1]);
    } else if (op->kind == OP_NEGATE) {
      for (int k = 0; k < PARTS; k += SIMD_WIDTH) {
        vfloat low = -v_load(w->high[top - 1] + k), high = -v_load(w->low[top - 1] + k);
        v_store(w->low[top - 1] + k, low);
        v_store(w->high[top - 1] + k, high);
      }
    } else {
      --top;
      bound_pair(w, op, i, top - 1);
      p->prunable |= (uint32_t)(w->first_idle[i] | w->second_idle[i]);
    }
  }
  uint32_t out = 0, deep = 0, in = 0, shallow = 0;
  for (int k = 0; k < PARTS; k += SIMD_WIDTH) {
    vfloat low = v_load(w->low[0] + k), high = v_load(w->high[0] + k), floor = v_set(run->floor);
    out |= v_bits(low > v_set(run->offset_max)) << k;
    deep |= v_bits(high <= floor) << k;
    in |= v_bits(high <= v_set(run->offset_min)) << k;
    shallow |= v_bits(low > floor) << k;
  }
  if (run->floor == -INFINITY) { /* nothing is deep, not even what is decided */
    deep = 0;
    shallow = 0xff;
  }
  p->bulk = in & shallow & lanes;
  p->deep = deep & ~out & lanes;
  p->straddling = lanes & ~(out | deep | p->bulk);
}

/* The program without what is idle in a part, as the last bound_parts found it. Keeps the old one where there is no room. */
static program_view prune(walk* w, program_view program, uint32_t part) {
  if (w->arena_used + program.length > ARENA_OPS) return program;
  uint16_t* out = w->arena + w->arena_used;
  uint32_t starts[SUPPORT_MAX_STACK], top = 0, length = 0;
  for (uint32_t i = 0; i < program.length; ++i) {
    uint16_t index = program.ops[i];
    const support_op* op = &w->ops[index];
    if (op_is_leaf(op->kind)) {
      starts[top++] = length;
      out[length++] = index;
    } else if (!op_is_pair(op->kind)) {
      out[length++] = index;
    } else {
      --top;
      if (w->second_idle[i] >> part & 1) {
        length = starts[top];
      } else if (w->first_idle[i] >> part & 1) {
        uint32_t kept = length - starts[top];
        memmove(out + starts[top - 1], out + starts[top], kept * sizeof *out);
        length = starts[top - 1] + kept;
        if (op->kind == OP_DIFFERENCE) out[length++] = (uint16_t)w->run->support->op_count;
      } else {
        out[length++] = index;
      }
    }
  }
  w->arena_used += length;
  return (program_view){out, length};
}

/* --- output ---------------------------------------------------------------------------------------------------------------- */

#if SIMD_WIDTH == 8
static inline __m256i cell_lanes(const uint8_t* cells) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64((const __m128i*)(const void*)cells));
}

/* Stores 8 records, given as the cells they stand in and their assets. */
static inline void store_columns(const cube_view* c, __m256i cx, __m256i cy, __m256i cz, __m256 asset, float* to) {
  __m256 x = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->place[0]), cx);
  __m256 y = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->place[1]), cy);
  __m256 z = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->place[2]), cz);
  __m256 xy_low = _mm256_unpacklo_ps(x, y), xy_high = _mm256_unpackhi_ps(x, y);
  __m256 za_low = _mm256_unpacklo_ps(z, asset), za_high = _mm256_unpackhi_ps(z, asset);
  __m256 r04 = _mm256_shuffle_ps(xy_low, za_low, 0x44), r15 = _mm256_shuffle_ps(xy_low, za_low, 0xee);
  __m256 r26 = _mm256_shuffle_ps(xy_high, za_high, 0x44), r37 = _mm256_shuffle_ps(xy_high, za_high, 0xee);
  _mm256_storeu_ps(to, _mm256_permute2f128_ps(r04, r15, 0x20));
  _mm256_storeu_ps(to + 8, _mm256_permute2f128_ps(r26, r37, 0x20));
  _mm256_storeu_ps(to + 16, _mm256_permute2f128_ps(r04, r15, 0x31));
  _mm256_storeu_ps(to + 24, _mm256_permute2f128_ps(r26, r37, 0x31));
}

/* Stores the records of 8 slots, in this order. */
static inline void store_records(const cube_view* c, uint32_t slot, __m256i order, float* to) {
  __m256i cx = _mm256_permutevar8x32_epi32(cell_lanes(c->slots.cx + slot), order);
  __m256i cy = _mm256_permutevar8x32_epi32(cell_lanes(c->slots.cy + slot), order);
  __m256i cz = _mm256_permutevar8x32_epi32(cell_lanes(c->slots.cz + slot), order);
  __m256 asset = _mm256_permutevar8x32_ps(_mm256_loadu_ps((const float*)(const void*)(c->slots.asset + slot)), order);
  store_columns(c, cx, cy, cz, asset, to);
}
#endif

static inline void write_one(const walk* w, const cube_view* c, uint32_t slot, uint64_t to) {
  const tile_slots* s = &c->slots;
  w->run->instances[to] =
      (scree_instance){{c->place[0][s->cx[slot]], c->place[1][s->cy[slot]], c->place[2][s->cz[slot]]}, s->asset[slot]};
}

static void write_ids(const walk* w, const cube_view* c, uint32_t slot, uint32_t mask, uint64_t to) {
  for (; mask != 0; mask &= mask - 1)
    w->run->ids[to++] =
        (scree_id){{c->at[0], c->at[1], c->at[2]}, (uint16_t)c->slots.local[slot + (uint32_t)__builtin_ctz(mask)], 0};
}

/* Delivers those of 8 slots that the mask has. */
static inline void emit_octet(walk* w, const cube_view* c, uint32_t slot, uint32_t mask) {
  const query_run* run = w->run;
  uint64_t to = w->count;
  w->count += (uint32_t)__builtin_popcount(mask);
  if (run->instances == NULL || mask == 0) return;
  if (to + FIELD_OCTET > run->capacity) { /* near the end of the buffer: one by one */
    for (uint32_t rest = mask; rest != 0 && to < run->capacity; rest &= rest - 1, ++to) {
      write_one(w, c, slot + (uint32_t)__builtin_ctz(rest), to);
      if (run->ids != NULL) write_ids(w, c, slot, rest & -rest, to);
    }
    return;
  }
  if (run->ids != NULL) write_ids(w, c, slot, mask, to);
#if SIMD_WIDTH == 8
  __m256i order = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128((int64_t)w->field->lane_order[mask]));
  store_records(c, slot, order, (float*)(run->instances + to));
#else
  for (; mask != 0; mask &= mask - 1) write_one(w, c, slot + (uint32_t)__builtin_ctz(mask), to++);
#endif
}

/* Which of 8 slots have their home cell in the query. */
static uint32_t octet_in_range(const cube_view* c, uint32_t slot) {
  const tile_slots* s = &c->slots;
  uint32_t mask = 0;
  for (uint32_t i = 0; i < FIELD_OCTET; ++i) {
    bool x = s->cx[slot + i] >= c->low[0] && s->cx[slot + i] < c->high[0];
    bool y = s->cy[slot + i] >= c->low[1] && s->cy[slot + i] < c->high[1];
    bool z = s->cz[slot + i] >= c->low[2] && s->cz[slot + i] < c->high[2];
    mask |= (uint32_t)(x && y && z) << i;
  }
  return mask;
}

static inline uint32_t octet_mask(const cube_view* c, uint32_t slot, uint32_t end) {
  uint32_t mask = end - slot < FIELD_OCTET ? (1u << (end - slot)) - 1 : 0xff;
  return c->border ? mask & octet_in_range(c, slot) : mask;
}

/* Delivers slots first .. end - 1, all of them that belong to the query. */
static void emit_slots(walk* w, const cube_view* c, uint32_t first, uint32_t end) {
  const query_run* run = w->run;
  if (!c->border && run->instances == NULL) {
    w->count += end - first;
    return;
  }
  uint32_t slot = first;
#if SIMD_WIDTH == 8
  if (!c->border && run->ids == NULL && w->count + (end - first) + FIELD_OCTET <= run->capacity) {
    float* record = (float*)(run->instances + w->count);
    for (; slot < end; slot += FIELD_OCTET, record += 4 * FIELD_OCTET)
      store_columns(c, cell_lanes(c->slots.cx + slot), cell_lanes(c->slots.cy + slot), cell_lanes(c->slots.cz + slot),
                    _mm256_loadu_ps((const float*)(const void*)(c->slots.asset + slot)), record);
    w->count += end - first;
    return;
  }
#endif
  for (; slot < end; slot += FIELD_OCTET) emit_octet(w, c, slot, octet_mask(c, slot, end));
}

/* --- cubes ----------------------------------------------------------------------------------------------------------------- */

/* Colours of the four corners (x, y..y+1, z..z+1) at bits 0, 2, 4, 6. */
static inline uint32_t side_colours(uint64_t seed, int32_t x, int32_t y, int32_t z) {
  uint32_t colours = 0;
  for (int32_t k = 0; k < 2; ++k) {
    uint64_t column = hash_combine(seed, (uint64_t)(uint32_t)x | (uint64_t)(uint32_t)(y + k) << 32); /* as in hash_corner */
    colours |= (uint32_t)(hash_combine(column, (uint32_t)z) >> 63) << (2 * k);
    colours |= (uint32_t)(hash_combine(column, (uint32_t)(z + 1)) >> 63) << (2 * k + 4);
  }
  return colours;
}

/* Centres of the cells of a cube along one axis; past the cube's own they are never read. */
static inline void place_axis(const walk* w, double base, int64_t cube, float out[8]) {
  double h = w->field->cell_size, first = (double)(cube * w->n);
  for (int i = 0; i < 8; ++i) out[i] = (float)(base + h * (first + i));
}

static void set_tile(const walk* w, cube_view* c, uint32_t code) {
  c->tile = &w->field->tiles[code];
  c->slots = field_slots(w->field, c->tile);
}

/* Notes which cells of the cube belong to the query. */
static inline void set_range(const walk* w, cube_view* c) {
  int64_t low[3], high[3];
  c->border = false;
  for (int a = 0; a < 3; ++a) {
    int64_t first = c->at[a] * w->n;
    low[a] = w->run->cell_low[a] - first;
    high[a] = w->run->cell_high[a] - first;
    c->low[a] = 0;
    c->high[a] = (uint8_t)w->n;
    c->border = c->border || low[a] > 0 || high[a] < w->n;
  }
  if (!c->border) return;
  for (int a = 0; a < 3; ++a) {
    c->low[a] = (uint8_t)(low[a] > 0 ? low[a] : 0);
    c->high[a] = (uint8_t)(high[a] < w->n ? high[a] : w->n);
  }
}

/* --- below the floor ------------------------------------------------------------------------------------------------------- */

/* Cells low .. high - 1 are deep, as far as they belong to the query. */
static void note_cells(const walk* w, const int64_t low[3], const int64_t high[3]) {
  const cell_grid* grid = w->run->deep;
  int64_t from[3], to[3];
  for (int a = 0; a < 3; ++a) {
    from[a] = low[a] > w->run->cell_low[a] ? low[a] : w->run->cell_low[a];
    to[a] = high[a] < w->run->cell_high[a] ? high[a] : w->run->cell_high[a];
    if (from[a] >= to[a]) return;
  }
  int64_t at[3] = {from[0], from[1], from[2]};
  for (; at[2] < to[2]; ++at[2])
    for (at[1] = from[1]; at[1] < to[1]; ++at[1]) memset(grid_cell(grid, at), SCREE_CELL_FULL, (size_t)(to[0] - from[0]));
}

/* Delivers those of slots first .. end - 1 that no burial hides. */
static void emit_bare(walk* w, const cube_view* c, uint32_t first, uint32_t end) {
  const uint8_t* bare = w->field->bare + (size_t)c->tile->rocks * FIELD_OCTET;
  for (uint32_t slot = first; slot < end; slot += FIELD_OCTET) {
    uint32_t mask = 0;
    for (uint32_t i = 0; i < FIELD_OCTET; ++i) mask |= (uint32_t)bare[slot + i] << i;
    if (mask != 0) emit_octet(w, c, slot, mask & octet_mask(c, slot, end));
  }
}

/* The same for whole cubes, all of them deep. */
static void visit_deep_cubes(walk* w, const int64_t low[3], const int64_t high[3]) {
  const int64_t n = w->n, cell_low[3] = {low[0] * n, low[1] * n, low[2] * n},
                cell_high[3] = {high[0] * n, high[1] * n, high[2] * n};
  note_cells(w, cell_low, cell_high);
  if (w->field->bare == NULL) return;
  cube_view c;
  float places[3][8];
  for (int a = 0; a < 3; ++a) c.place[a] = places[a];
  int64_t at[3];
  for (at[2] = low[2]; at[2] < high[2]; ++at[2])
    for (at[1] = low[1]; at[1] < high[1]; ++at[1])
      for (at[0] = low[0]; at[0] < high[0]; ++at[0]) {
        for (int a = 0; a < 3; ++a) {
          c.at[a] = (int32_t)at[a];
          place_axis(w, w->run->out_base[a], at[a], places[a]);
        }
        set_tile(w, &c,
                 side_colours(w->field->seed, c.at[0], c.at[1], c.at[2]) |
                     side_colours(w->field->seed, c.at[0] + 1, c.at[1], c.at[2]) << 1);
        set_range(w, &c);
        emit_bare(w, &c, 0, c.tile->block_first[FIELD_BLOCKS]);
      }
}

/* Notes those of 8 slots that the mask has; returns those of them that are delivered all the same. */
static uint32_t note_octet(const walk* w, const cube_view* c, uint32_t slot, uint32_t mask) {
  const tile_slots* s = &c->slots;
  uint32_t bare = 0;
  for (; mask != 0; mask &= mask - 1) {
    uint32_t i = (uint32_t)__builtin_ctz(mask), k = slot + i;
    if (w->field->bare != NULL && w->field->bare[(size_t)c->tile->rocks * FIELD_OCTET + k]) {
      bare |= 1u << i;
      continue;
    }
    const int64_t cell[3] = {c->at[0] * w->n + s->cx[k], c->at[1] * w->n + s->cy[k], c->at[2] * w->n + s->cz[k]};
    grid_add(grid_cell(w->run->deep, cell), w->field->hidings[s->asset[k]].siblings);
  }
  return bare;
}

/* Rocks of a cube that have to be looked at one by one, up to 64 at a time. */
typedef struct batch {
  float x[SUPPORT_BATCH], y[SUPPORT_BATCH], z[SUPPORT_BATCH];
  uint32_t slot[SUPPORT_BATCH / FIELD_OCTET];
  uint8_t mask[SUPPORT_BATCH / FIELD_OCTET];
  uint32_t octets;
} batch;

static void flush(walk* w, const cube_view* c, program_view program, batch* b) {
  const query_run* run = w->run;
  evaluate_program(w->ops, program.ops, program.length, b->x, b->y, b->z, w->values, b->octets * FIELD_OCTET,
                   run->slope == 0 && run->floor == -INFINITY);
  for (uint32_t o = 0; o < b->octets; ++o) {
    uint32_t exists = 0, deep = 0;
    for (uint32_t k = 0; k < FIELD_OCTET; k += SIMD_WIDTH) {
      vfloat d = v_load(w->values[0] + o * FIELD_OCTET + k);
      vfloat offset = v_set(0);
      if (run->slope != 0) offset = v_set(run->slope) * v_load(c->slots.mean_radius + b->slot[o] + k);
      exists |= v_bits((d <= offset) & (d > v_set(run->floor))) << k;
      deep |= v_bits(d <= v_set(run->floor)) << k;
    }
    deep &= b->mask[o];
    if (run->deep != NULL && deep != 0) exists |= note_octet(w, c, b->slot[o], deep);
    emit_octet(w, c, b->slot[o], exists & b->mask[o]);
  }
  b->octets = 0;
}

static inline void gather_octet(const cube_view* c, uint32_t slot, float* x, float* y, float* z) {
  const tile_slots* s = &c->slots;
#if SIMD_WIDTH == 8
  __m256 px = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->test[0]), cell_lanes(s->cx + slot));
  __m256 py = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->test[1]), cell_lanes(s->cy + slot));
  __m256 pz = _mm256_permutevar8x32_ps(_mm256_loadu_ps(c->test[2]), cell_lanes(s->cz + slot));
  _mm256_storeu_ps(x, _mm256_add_ps(px, _mm256_loadu_ps(s->x + slot)));
  _mm256_storeu_ps(y, _mm256_add_ps(py, _mm256_loadu_ps(s->y + slot)));
  _mm256_storeu_ps(z, _mm256_add_ps(pz, _mm256_loadu_ps(s->z + slot)));
#else
  for (uint32_t i = 0; i < FIELD_OCTET; ++i) {
    x[i] = c->test[0][s->cx[slot + i]] + s->x[slot + i];
    y[i] = c->test[1][s->cy[slot + i]] + s->y[slot + i];
    z[i] = c->test[2][s->cz[slot + i]] + s->z[slot + i];
  }
#endif
}

static void test_slots(walk* w, const cube_view* c, program_view program, batch* b, uint32_t first, uint32_t end) {
  for (uint32_t slot = first; slot < end; slot += FIELD_OCTET) {
    uint32_t mask = octet_mask(c, slot, end);
    if (mask == 0) continue;
    uint32_t o = b->octets++;
    b->slot[o] = slot;
    b->mask[o] = (uint8_t)mask;
    gather_octet(c, slot, b->x + o * FIELD_OCTET, b->y + o * FIELD_OCTET, b->z + o * FIELD_OCTET);
    if (b->octets == SUPPORT_BATCH / FIELD_OCTET) flush(w, c, program, b);
  }
}

static inline uint32_t block_kind(const parts* p, uint32_t b) {
  return (p->bulk >> b & 1) | (p->straddling >> b & 1) << 1 | (p->deep >> b & 1) << 2;
}

/* What the cubes of a node of 2 x 2 x 2 share: the centres of their cells. */
typedef struct axis_places {
  float test[3][2][8], place[3][2][8];
  bool placed; /* `place` is filled */
} axis_places;

/* A straddling cube, child `child` of the node at `node`: block by block. */
__attribute__((noinline)) static void visit_cube(walk* w, const int64_t node[3], uint32_t child, axis_places* places,
                                                 program_view program) {
  const query_run* run = w->run;
  const scree_field* field = w->field;
  const field_balls* balls = &field->balls;
  cube_view c;
  parts p;
  for (int a = 0; a < 3; ++a) {
    c.at[a] = (int32_t)(node[a] + (child >> a & 1));
    c.test[a] = places->test[a][child >> a & 1];
    c.place[a] = places->place[a][child >> a & 1];
  }
  set_range(w, &c);
  uint32_t lanes = 0xff;
  for (uint32_t b = 0; b < FIELD_BLOCKS && c.border; ++b)
    for (int a = 0; a < 3; ++a)
      if (block_low(field, b, a) >= c.high[a] || block_high(field, b, a) <= c.low[a]) lanes &= ~(1u << b);
  for (int i = 0; i < PARTS; i += SIMD_WIDTH) {
    v_store(p.x + i, v_set(c.test[0][0]) + v_load(balls->x + i));
    v_store(p.y + i, v_set(c.test[1][0]) + v_load(balls->y + i));
    v_store(p.z + i, v_set(c.test[2][0]) + v_load(balls->z + i));
    v_store(p.radius + i, v_load(balls->radius + i));
  }
  bound_parts(w, program, &p, lanes);
  if (run->deep == NULL) p.deep = 0;
  for (uint32_t b = 0; b < FIELD_BLOCKS; ++b) {
    if (!(p.deep >> b & 1)) continue;
    int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = c.at[a] * w->n + block_low(field, b, a);
      high[a] = c.at[a] * w->n + block_high(field, b, a);
    }
    note_cells(w, low, high);
  }
  if (field->bare == NULL) p.deep = 0;
  if ((p.bulk | p.straddling | p.deep) == 0) return;

  set_tile(w, &c,
           side_colours(field->seed, c.at[0], c.at[1], c.at[2]) | side_colours(field->seed, c.at[0] + 1, c.at[1], c.at[2]) << 1);
  if (!places->placed) {
    for (int a = 0; a < 3; ++a)
      for (int s = 0; s < 2; ++s) place_axis(w, run->out_base[a], node[a] + s, places->place[a][s]);
    places->placed = true;
  }
  batch todo;
  todo.octets = 0;
  for (uint32_t b = 0; b < FIELD_BLOCKS;) { /* runs of blocks with the same fate are neighbours in the slots */
    uint32_t kind = block_kind(&p, b), first = b;
    while (b < FIELD_BLOCKS && block_kind(&p, b) == kind) ++b;
    if (kind == 1) emit_slots(w, &c, c.tile->block_first[first], c.tile->block_first[b]);
    if (kind == 2) test_slots(w, &c, program, &todo, c.tile->block_first[first], c.tile->block_first[b]);
    if (kind == 4) emit_bare(w, &c, c.tile->block_first[first], c.tile->block_first[b]);
  }
  if (todo.octets > 0) flush(w, &c, program, &todo);
}

/* All rocks of whole cubes: low <= at < high, as far as their cells belong to the query. */
__attribute__((noinline)) static void emit_cubes(walk* w, const int64_t low[3], const int64_t high[3]) {
  const query_run* run = w->run;
  const scree_field* field = w->field;
  cube_view c;
  float places[3][8];
  for (int a = 0; a < 3; ++a) c.place[a] = places[a];
  for (int64_t z = low[2]; z < high[2]; ++z)
    for (int64_t y = low[1]; y < high[1]; ++y) {
      c.at[1] = (int32_t)y;
      c.at[2] = (int32_t)z;
      place_axis(w, run->out_base[1], y, places[1]);
      place_axis(w, run->out_base[2], z, places[2]);
      uint32_t left = side_colours(field->seed, (int32_t)low[0], c.at[1], c.at[2]);
      for (int64_t x = low[0]; x < high[0]; ++x) {
        c.at[0] = (int32_t)x;
        place_axis(w, run->out_base[0], x, places[0]);
        uint32_t right = side_colours(field->seed, c.at[0] + 1, c.at[1], c.at[2]);
        set_tile(w, &c, left | right << 1);
        left = right;
        set_range(w, &c);
        emit_slots(w, &c, 0, c.tile->block_first[FIELD_BLOCKS]);
      }
    }
}

/* --- octree ---------------------------------------------------------------------------------------------------------------- */

/* One half of a node along one axis. */
typedef struct node_side {
  int64_t low, high;  /* cubes, cut to the query's */
  float centre, half; /* of the box that holds the centroids, support's space */
  bool some;
} node_side;

static node_side side_of(const walk* w, int axis, int64_t low, int64_t high) {
  const query_run* run = w->run;
  const scree_field* field = w->field;
  node_side s = {low > run->cube_low[axis] ? low : run->cube_low[axis], high < run->cube_high[axis] ? high : run->cube_high[axis],
                 0, 0, false};
  if (s.low >= s.high) return s;
  int64_t first = s.low * w->n, last = s.high * w->n - 1; /* cells */
  if (first < run->cell_low[axis]) first = run->cell_low[axis];
  if (last > run->cell_high[axis] - 1) last = run->cell_high[axis] - 1;
  double stray_low = (double)field->centroid_min[axis], stray_high = (double)field->centroid_max[axis];
  s.centre = (float)(run->test_base[axis] + field->cell_size * ((double)(first + last) * 0.5) + (stray_low + stray_high) * 0.5);
  s.half = (float)(field->cell_size * ((double)(last - first) * 0.5) + (stray_high - stray_low) * 0.5);
  s.some = true;
  return s;
}

/* A node of 2^k cubes a side, k >= 1: its eight children. */
static void visit_node(walk* w, const int64_t at[3], int64_t size, program_view program) {
  int64_t half = size / 2;
  node_side sides[3][2];
  for (int a = 0; a < 3; ++a)
    for (int s = 0; s < 2; ++s) sides[a][s] = side_of(w, a, at[a] + s * half, at[a] + (s + 1) * half);
  parts p;
  uint32_t lanes = 0;
  for (uint32_t c = 0; c < PARTS; ++c) {
    const node_side *x = &sides[0][c & 1], *y = &sides[1][c >> 1 & 1], *z = &sides[2][c >> 2];
    p.x[c] = x->centre;
    p.y[c] = y->centre;
    p.z[c] = z->centre;
    p.radius[c] = sqrtf(x->half * x->half + y->half * y->half + z->half * z->half);
    lanes |= (uint32_t)(x->some && y->some && z->some) << c;
  }
  bound_parts(w, program, &p, lanes);

  uint32_t mark = w->arena_used;
  axis_places places;
  bool tested = false;
  program_view programs[PARTS];
  for (uint32_t c = 0; c < PARTS; ++c) /* before the children, who use the same scratch */
    if (p.straddling >> c & 1) programs[c] = (p.prunable >> c & 1) && !w->run->whole ? prune(w, program, c) : program;
  for (uint32_t c = 0; c < PARTS; ++c) {
    const node_side *x = &sides[0][c & 1], *y = &sides[1][c >> 1 & 1], *z = &sides[2][c >> 2];
    const int64_t low[3] = {x->low, y->low, z->low}, high[3] = {x->high, y->high, z->high};
    if (p.bulk >> c & 1) emit_cubes(w, low, high);
    if (w->run->deep != NULL && (p.deep >> c & 1)) visit_deep_cubes(w, low, high);
    if (!(p.straddling >> c & 1)) continue;
    if (half == 1) {
      if (!tested) {
        for (int a = 0; a < 3; ++a)
          for (int k = 0; k < 2; ++k) place_axis(w, w->run->test_base[a], at[a] + k, places.test[a][k]);
        tested = true;
        places.placed = false;
      }
      visit_cube(w, at, c, &places, programs[c]);
    } else {
      const int64_t child[3] = {at[0] + half * (c & 1), at[1] + half * (c >> 1 & 1), at[2] + half * (c >> 2)};
      visit_node(w, child, half, programs[c]);
    }
  }
  w->arena_used = mark;
}

static void walk_query(query_run* run) {
  walk w;
  w.run = run;
  w.field = run->field;
  w.ops = run->support->ops;
  w.n = run->field->cells_per_cube;
  w.count = 0;
  w.arena_used = 0;
  int64_t at[3], size = 2;
  for (int a = 0; a < 3; ++a) {
    at[a] = run->cube_low[a];
    while (size < (int64_t)run->cube_high[a] - run->cube_low[a]) size *= 2;
  }
  visit_node(&w, at, size, (program_view){run->support->program, run->support->op_count});
  run->count = w.count;
}

#endif
