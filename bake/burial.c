/* Lines from the surface of every rock in all directions, through the rocks around it, until a rock stops them: the ring of cells
 * that it is in says how far one sees from here, and so from how far one is seen.
 *
 * No rock is hidden for good. A pile is 0.6 rock and 0.4 gap, a line passes half a cell of it on average, and each ring of cells
 * stops nine of ten that are left. The farthest of LINES lines ends in ring r, which finds what one line in some thousands sees;
 * a rock is buried r + 1 deep, so that the ring beyond stops nearly all lines that the sample does not have. (Lines end at the
 * finest level of the rocks: the coarser ones hold the same volume. They are followed in several colourings of the corners that
 * the rock's own cell does not depend on.) */
#include "burial.h"

#include <string.h>

#include "plain_mesh.h"
#include "random.h"

enum {
  RINGS = SCREE_BURIAL_NEVER - 2, /* that lines are followed through */
  MARGIN = RINGS + 1,             /* cells around the tile: rings, and what sticks out of them */
  COLOURINGS = 2,
  DIRECTIONS = 256,
  LINES = 1600, /* of a rock in each colouring, about */
  MOST_POINTS = 64,
  UNKNOWN = 128, /* bit of a voxel that is not filled yet */
  ONE = 1 << 16  /* a voxel in the fixed-point numbers of lines */
};
#define STRIDE 1.0 /* voxels from sample to sample of a line */

/* Cells of the scratch. */
static size_t cells_of(const bake_run* bake) {
  const size_t side = bake->seeds.n + 2 * MARGIN;
  return side * side * side;
}

scree_result burial_scratch_create(const bake_run* bake, burial_scratch* out) {
  out->per_cell = bake->seeds.voxels / mask_step(bake->seeds.voxels);
  out->side = (size_t)(bake->seeds.n + 2 * MARGIN) * out->per_cell;
  for (uint32_t bits = 0; bits < 256; ++bits) {
    out->bytes_of[bits] = 0;
    for (uint32_t i = 0; i < 8; ++i)
      if (bits >> i & 1) out->bytes_of[bits] |= UINT64_C(255) << (8 * i);
  }
  out->owners = scree_rt_allocate(&bake->allocator, out->side * out->side * out->side, 1);
  out->added = scree_rt_allocate(&bake->allocator, cells_of(bake), 1);
  if (out->owners != NULL && out->added != NULL) return SCREE_OK;
  burial_scratch_destroy(bake, out);
  return SCREE_ERROR_OUT_OF_MEMORY;
}

void burial_scratch_destroy(const bake_run* bake, burial_scratch* scratch) {
  scree_rt_release(&bake->allocator, scratch->owners, scratch->side * scratch->side * scratch->side, 1);
  scree_rt_release(&bake->allocator, scratch->added, cells_of(bake), 1);
  memset(scratch, 0, sizeof *scratch);
}

/* First voxel of the box of two cells around cell `c`, which counts from the tile's first. */
static int32_t box_start(const burial_scratch* scratch, int32_t c) {
  const int32_t per_cell = (int32_t)scratch->per_cell;
  return (c + MARGIN) * per_cell - per_cell / 2;
}

/* Marks the voxels of a rock with where its home cell lies from the voxel's: 1 + (x + 1) + 3 (y + 1) + 9 (z + 1). Eight voxels at a
 * time: rocks do not overlap, so that marks can be added. */
static void add_rock(burial_scratch* scratch, const rock_mask* mask, const int32_t cell[3]) {
  const uint32_t* next = mask->rows;
  const int32_t per_cell = (int32_t)scratch->per_cell;
  uint8_t along_x[32] = {0};
  const int32_t x0 = box_start(scratch, cell[0]);
  for (int32_t x = 0; x < mask->size[0]; ++x) along_x[x] = (uint8_t)(2 + cell[0] + MARGIN - (x0 + x) / per_cell);
  uint64_t marks_x[4];
  memcpy(marks_x, along_x, sizeof marks_x);
  for (int32_t k = 0; k < mask->size[2]; ++k)
    for (int32_t j = 0; j < mask->size[1]; ++j) {
      uint32_t row = *next++;
      if (row == 0) continue;
      const int32_t y = box_start(scratch, cell[1]) + mask->min[1] + j, z = box_start(scratch, cell[2]) + mask->min[2] + k;
      const int32_t yz = 3 * (1 + cell[1] + MARGIN - y / per_cell) + 9 * (1 + cell[2] + MARGIN - z / per_cell);
      const uint64_t marks_yz = (uint64_t)yz * UINT64_C(0x0101010101010101);
      uint8_t* at = scratch->owners + (size_t)x0 + scratch->side * ((size_t)y + scratch->side * (size_t)z);
      for (uint32_t group = 0; row != 0; row >>= 8, ++group) {
        uint64_t marks;
        memcpy(&marks, at + (size_t)8 * group, sizeof marks);
        marks |= (marks_x[group] + marks_yz) & scratch->bytes_of[row & 255];
        memcpy(at + (size_t)8 * group, &marks, sizeof marks);
      }
    }
}

/* A tile whose corners have this code, among tiles whose other corners are coloured by a key. Voxels are filled where lines come
 * by: few go far. */
typedef struct surroundings {
  const bake_run* bake;
  const rock_mask* masks;
  burial_scratch* scratch;
  uint64_t key;
  uint32_t code;
} surroundings;

static void begin(const surroundings* s) {
  memset(s->scratch->owners, UNKNOWN, s->scratch->side * s->scratch->side * s->scratch->side);
  memset(s->scratch->added, 0, cells_of(s->bake));
}

static void add_cell(const surroundings* s, const int32_t cell[3]) {
  const int32_t n = (int32_t)s->bake->seeds.n;
  int32_t tile[3];
  uint32_t within[3], code = 0;
  for (int axis = 0; axis < 3; ++axis) {
    tile[axis] = (cell[axis] + n * MARGIN) / n - MARGIN;
    within[axis] = (uint32_t)(cell[axis] - tile[axis] * n);
  }
  for (int32_t corner = 0; corner < 8; ++corner) {
    const int32_t x = tile[0] + (corner & 1), y = tile[1] + (corner >> 1 & 1), z = tile[2] + (corner >> 2);
    const bool own = (x | y | z) >> 1 == 0; /* each 0 or 1 */
    code |= (own ? s->code >> (x + 2 * y + 4 * z) & 1 : corner_colour(s->key, x, y, z)) << corner;
  }
  const uint32_t unique = scree_rt_lattice_cell((uint32_t)n, code, within[0], within[1], within[2]);
  for (uint32_t slot = s->bake->cell_rocks[unique]; slot < s->bake->cell_rocks[unique + 1]; ++slot)
    if (s->masks[slot].rows != NULL) add_rock(s->scratch, &s->masks[slot], cell);
}

/* Fills the voxels of a cell, which counts from the first of the margin. Rocks reach half a cell into their neighbours. */
static void fill(const surroundings* s, const int32_t at[3]) {
  burial_scratch* scratch = s->scratch;
  const int32_t n = (int32_t)s->bake->seeds.n, cells = n + 2 * MARGIN;
  const size_t per_cell = scratch->per_cell, side = scratch->side;
  int32_t c[3];
  for (c[2] = at[2] - 1; c[2] <= at[2] + 1; ++c[2])
    for (c[1] = at[1] - 1; c[1] <= at[1] + 1; ++c[1])
      for (c[0] = at[0] - 1; c[0] <= at[0] + 1; ++c[0]) {
        const int32_t cell[3] = {c[0] - MARGIN, c[1] - MARGIN, c[2] - MARGIN};
        bool inside = true;
        for (int axis = 0; axis < 3; ++axis) inside = inside && cell[axis] >= -RINGS && cell[axis] < n + RINGS;
        if (!inside) continue;
        uint8_t* added = &scratch->added[c[0] + cells * (c[1] + cells * c[2])];
        if (*added == 0) add_cell(s, cell);
        *added = 1;
      }
  for (size_t z = 0; z < per_cell; ++z)
    for (size_t y = 0; y < per_cell; ++y) {
      uint8_t* row = scratch->owners + (size_t)at[0] * per_cell +
                     side * ((size_t)at[1] * per_cell + y + side * ((size_t)at[2] * per_cell + z));
      for (size_t x = 0; x < per_cell; ++x) row[x] &= UNKNOWN - 1;
    }
}

/* Follows a line, by `step` from sample to sample. home: the cell that it comes from, counted from the first of the
 * margin. Returns the ring of the rock that stops it, RINGS + 1 if none does. */
static uint32_t follow(const surroundings* s, const int32_t home[3], const int32_t from[3], const int32_t step[3]) {
  const burial_scratch* scratch = s->scratch;
  const int32_t per_cell = (int32_t)scratch->per_cell, side = (int32_t)scratch->side;
  /* To where rocks of the outermost ring reach at most. */
  int32_t count = INT32_MAX;
  for (int axis = 0; axis < 3; ++axis) {
    const int32_t middle = home[axis] * per_cell * ONE + per_cell * (ONE / 2), reach = (RINGS + 1) * per_cell * ONE;
    const int32_t way = step[axis] > 0 ? middle + reach - from[axis] : from[axis] - (middle - reach);
    const int32_t size = step[axis] > 0 ? step[axis] : -step[axis];
    if (size != 0 && way / size < count) count = way / size;
  }
  int32_t p[3] = {from[0], from[1], from[2]};
  for (int32_t i = 1; i < count; ++i) {
    p[0] += step[0], p[1] += step[1], p[2] += step[2];
    const int32_t at[3] = {p[0] / ONE, p[1] / ONE, p[2] / ONE};
    const uint8_t* voxel = &scratch->owners[(size_t)(at[0] + side * (at[1] + side * at[2]))];
    if (*voxel == 0) continue;
    if (*voxel >= UNKNOWN) {
      const int32_t cell[3] = {at[0] / per_cell, at[1] / per_cell, at[2] / per_cell};
      fill(s, cell);
      if (*voxel == 0) continue;
    }
    const int32_t owner = *voxel - 1;
    const int32_t offset[3] = {owner % 3 - 1, owner / 3 % 3 - 1, owner / 9 - 1};
    int32_t ring = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int32_t off = at[axis] / per_cell + offset[axis] - home[axis], far = off < 0 ? -off : off;
      if (far > ring) ring = far;
    }
    if (ring <= RINGS) return (uint32_t)ring;
  }
  return RINGS + 1;
}

static void make_directions(int32_t (*out)[3]) {
  random_stream stream = {UINT64_C(0xb0417)};
  for (uint32_t i = 0; i < DIRECTIONS; ++i) {
    double direction[3];
    random_direction(&stream, direction);
    for (int axis = 0; axis < 3; ++axis) out[i][axis] = (int32_t)floor(direction[axis] * STRIDE * ONE);
  }
}

/* Where the lines of a rock start: vertices of its hull and of its coarsest level, on its surface or a little outside. */
static uint32_t gather_points(const bake_run* bake, const rock_record* rock, const int32_t cell[3], const burial_scratch* scratch,
                              int32_t (*points)[3]) {
  const rock_lod* coarsest = &rock->lods[bake->recipe.lod_levels - 1];
  plain_mesh mesh;
  scree_rt_plain_mesh_read(coarsest->blob, coarsest->blob_size, coarsest->vertex_count, coarsest->triangle_count, false, &mesh);
  uint32_t count = 0;
  const uint32_t total = rock->hull_count + mesh.vertex_count, skip = (total + MOST_POINTS - 1) / MOST_POINTS;
  const int64_t per_voxel = (int64_t)bake->recipe.lattice_steps * mask_step(bake->seeds.voxels);
  for (uint32_t i = 0; i < total; i += skip) {
    for (uint32_t axis = 0; axis < 3; ++axis) {
      const int32_t p =
          i < rock->hull_count ? rock->hull[i][axis] : scree_rt_plain_mesh_coordinate(&mesh, i - rock->hull_count, axis);
      /* Lattice steps from the home cell's centre to voxels of the grid of samples' corners: half a fine voxel less. */
      const int64_t from_box = 2 * p + 1 + (int64_t)bake->recipe.lattice_steps * (2 * (int64_t)bake->seeds.voxels - 1);
      points[count][axis] = box_start(scratch, cell[axis]) * ONE + (int32_t)(from_box * ONE / (2 * per_voxel));
    }
    ++count;
  }
  return count;
}

/* Whether a cell is looked at in this tile. One on a corner plane stands in 16, 64 or 128 tiles, which differ in corners that it
 * does not depend on; one or two of these are enough. */
static bool is_chosen(uint32_t code, uint32_t cell, uint32_t x, uint32_t y, uint32_t z) {
  const uint32_t pinned = (x == 0 ? 1u : 0u) | (y == 0 ? 2u : 0u) | (z == 0 ? 4u : 0u);
  if (pinned == 0) return true;
  uint32_t variant = 0, bits = 0;
  for (uint32_t corner = 0; corner < 8; ++corner)
    if ((corner & pinned) != 0) variant |= (code >> corner & 1) << bits++;
  const uint32_t share = bits == 4 ? 16 : bits == 6 ? 32 : 64;
  return variant % share == hash_mix(cell) % share;
}

void burial_of_tile(const bake_run* bake, uint32_t code, const rock_mask* masks, const rock_record* rocks, atomic_uint* burials,
                    burial_scratch* scratch) {
  int32_t directions[DIRECTIONS][3], points[MOST_POINTS][3];
  make_directions(directions);
  const uint32_t n = bake->seeds.n;
  for (uint32_t colouring = 0; colouring < COLOURINGS; ++colouring) {
    const uint64_t key = hash_combine(hash_combine(bake->recipe.random_seed, UINT64_C(0xb417)), code * COLOURINGS + colouring);
    const surroundings around = {bake, masks, scratch, key, code};
    begin(&around);
    for (uint32_t place = 0; place < n * n * n; ++place) {
      const uint32_t x = place % n, y = place / n % n, z = place / n / n, cell = scree_rt_lattice_cell(n, code, x, y, z);
      if (!is_chosen(code, cell, x, y, z)) continue;
      const int32_t at[3] = {(int32_t)x, (int32_t)y, (int32_t)z};
      const int32_t home[3] = {at[0] + MARGIN, at[1] + MARGIN, at[2] + MARGIN};
      for (uint32_t slot = bake->cell_rocks[cell]; slot < bake->cell_rocks[cell + 1]; ++slot) {
        if (masks[slot].rows == NULL) continue;
        const uint32_t point_count = gather_points(bake, &rocks[slot], at, scratch, points);
        const uint32_t lines = LINES / point_count < DIRECTIONS ? LINES / point_count : DIRECTIONS;
        uint32_t farthest = 0;
        for (uint32_t p = 0; p < point_count; ++p) {
          const uint32_t first = (uint32_t)hash_combine(key, (uint64_t)slot << 8 | p);
          for (uint32_t i = 0; i < lines; ++i) {
            const uint32_t ring = follow(&around, home, points[p], directions[(first + i * 97) % DIRECTIONS]);
            if (ring > farthest) farthest = ring;
          }
        }
        uint32_t before = atomic_load_explicit(&burials[slot], memory_order_relaxed);
        while (farthest + 1 > before && !atomic_compare_exchange_weak_explicit(&burials[slot], &before, farthest + 1,
                                                                               memory_order_relaxed, memory_order_relaxed))
          ;
      }
    }
  }
}
