/* Poisson discs whose radius grows along one direction: cells of an octree are where a seed may still lie. Darts are thrown at
 * them; a cell that one disc covers as a whole is done with, one that is not is cut into eight, and so on until what is left is
 * slivers. Based on: Ebeida, Mitchell, Patney, Davidson, Owens, A Simple Algorithm for Maximal Poisson-Disk Sampling in High
 * Dimensions, 2012; with a radius that changes. Two seeds are too near where one lies within the other's radius, whichever is
 * larger. */
#include <string.h>

#include "random.h"
#include "recipe_text.h"
#include "seed_lay.h"

enum { ROUNDS = 6, DARTS_PER_CELL = 1, MOST_CELLS = 60000000, LARGEST_GRID = 1 << 24 };

/* Where a seed may still lie. */
typedef struct dart_cell {
  float low[3]; /* in sides of the coarsest cells: exact */
  float side;
} dart_cell;

typedef struct cell_list {
  dart_cell* cells;
  size_t count, capacity;
} cell_list;

/* Seeds by boxes, chained. */
typedef struct dart_board {
  seed_job* job;
  const seed_radius* radius;
  double low_radius, high_radius, slope; /* of the radius, per length */
  double unit;                           /* side of the coarsest cells */
  double min[3], step;
  uint32_t size[3];
  uint32_t* heads; /* first seed of a box + 1 */
  uint32_t* next;  /* of each seed + 1 */
  uint32_t next_capacity;
} dart_board;

static bool push(cell_list* list, const dart_cell* cell, const scree_allocator* allocator) {
  if (list->count == list->capacity) {
    const size_t capacity = list->capacity < 1024 ? 1024 : 2 * list->capacity;
    dart_cell* cells = capacity > MOST_CELLS ? NULL : scree_rt_allocate(allocator, capacity, sizeof *cells);
    if (cells == NULL) return false;
    if (list->count > 0) memcpy(cells, list->cells, list->count * sizeof *cells);
    scree_rt_release(allocator, list->cells, list->capacity, sizeof *cells);
    list->cells = cells;
    list->capacity = capacity;
  }
  list->cells[list->count++] = *cell;
  return true;
}

static void drop(cell_list* list, const scree_allocator* allocator) {
  scree_rt_release(allocator, list->cells, list->capacity, sizeof *list->cells);
  memset(list, 0, sizeof *list);
}

static int32_t box_of(const dart_board* b, int a, double x) {
  const double at = floor((x - b->min[a]) / b->step);
  return !(at > 0) ? 0 : at >= b->size[a] ? (int32_t)b->size[a] - 1 : (int32_t)at;
}

static uint32_t* head_of(const dart_board* b, int32_t x, int32_t y, int32_t z) {
  return &b->heads[((size_t)z * b->size[1] + (size_t)y) * b->size[0] + (size_t)x];
}

/* From how far seeds may keep others away from a point with radius r: theirs may be larger, but not by more than the slope allows.
 */
static double farthest(const dart_board* b, double r) {
  const double most = b->slope < 0.99 ? r / (1 - b->slope) * (1 + 1e-9) : b->high_radius;
  return fmin(most, b->high_radius);
}

/* Whether a seed may lie at p. */
static bool is_free(const dart_board* b, const double p[3]) {
  const double r = seed_radius_at(b->radius, p), most = farthest(b, r);
  int32_t low[3], high[3];
  for (int a = 0; a < 3; ++a) low[a] = box_of(b, a, p[a] - most), high[a] = box_of(b, a, p[a] + most);
  for (int32_t z = low[2]; z <= high[2]; ++z)
    for (int32_t y = low[1]; y <= high[1]; ++y)
      for (int32_t x = low[0]; x <= high[0]; ++x)
        for (uint32_t at = *head_of(b, x, y, z); at != 0; at = b->next[at - 1]) {
          const double* q = b->job->seeds.points + (size_t)3 * (at - 1);
          const double d2 = (q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) + (q[2] - p[2]) * (q[2] - p[2]);
          const double limit = fmax(r, seed_radius_at(b->radius, q));
          if (d2 < limit * limit) return false;
        }
  return true;
}

/* Whether one seed keeps all others out of a cell: by its own radius or by the least of those within the cell. */
static bool is_covered(const dart_board* b, const double middle[3], double half) {
  const double r = seed_radius_at(b->radius, middle), change = b->slope * half * 1.7320508075688773;
  const double most = farthest(b, r + change), least = r - change;
  int32_t low[3], high[3];
  for (int a = 0; a < 3; ++a) low[a] = box_of(b, a, middle[a] - most), high[a] = box_of(b, a, middle[a] + most);
  for (int32_t z = low[2]; z <= high[2]; ++z)
    for (int32_t y = low[1]; y <= high[1]; ++y)
      for (int32_t x = low[0]; x <= high[0]; ++x)
        for (uint32_t at = *head_of(b, x, y, z); at != 0; at = b->next[at - 1]) {
          const double* q = b->job->seeds.points + (size_t)3 * (at - 1);
          double d2 = 0;
          for (int a = 0; a < 3; ++a) {
            const double d = fabs(q[a] - middle[a]) + half;
            d2 += d * d;
          }
          const double limit = fmax(least, seed_radius_at(b->radius, q));
          if (d2 < limit * limit) return true;
        }
  return false;
}

static scree_result add(dart_board* b, const double p[3]) {
  seed_job* job = b->job;
  const scree_result result = seed_add(job, p);
  if (result != SCREE_OK) return result;
  if (b->next_capacity < job->seeds.capacity) {
    uint32_t* next = scree_rt_allocate(&job->allocator, job->seeds.capacity, sizeof *next);
    if (next == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
    if (b->next_capacity > 0) memcpy(next, b->next, b->next_capacity * sizeof *next);
    scree_rt_release(&job->allocator, b->next, b->next_capacity, sizeof *next);
    b->next = next;
    b->next_capacity = job->seeds.capacity;
  }
  const uint32_t seed = job->seeds.count - 1;
  uint32_t* head = head_of(b, box_of(b, 0, p[0]), box_of(b, 1, p[1]), box_of(b, 2, p[2]));
  b->next[seed] = *head;
  *head = seed + 1;
  return SCREE_OK;
}

static void middle_of(const dart_board* b, const dart_cell* cell, double middle[3], double* half) {
  *half = (double)cell->side * b->unit / 2;
  for (int a = 0; a < 3; ++a) middle[a] = b->min[a] + (double)cell->low[a] * b->unit + *half;
}

/* Whether the mask has any box that a cell lies in: no cell is larger than two boxes, so that its corners and what is midway
 * between them lie in all of them. */
static bool is_near(const dart_board* b, const seed_mask* mask, const dart_cell* cell) {
  double middle[3], half;
  middle_of(b, cell, middle, &half);
  for (int i = 0; i < 27; ++i) {
    const double p[3] = {middle[0] + (i % 3 - 1) * half, middle[1] + (i / 3 % 3 - 1) * half, middle[2] + (i / 9 - 1) * half};
    if (seed_mask_has(mask, p)) return true;
  }
  return false;
}

/* A cell or, where it is larger than a disc, its parts. */
static bool push_fine(const dart_board* b, const seed_mask* mask, cell_list* list, const dart_cell* cell) {
  double middle[3], half;
  middle_of(b, cell, middle, &half);
  if (!is_near(b, mask, cell)) return true;
  if (2 * half * 1.7320508075688773 <= seed_radius_at(b->radius, middle) * 1.001) return push(list, cell, &b->job->allocator);
  for (int i = 0; i < 8; ++i) {
    dart_cell part = {.side = cell->side / 2};
    for (int a = 0; a < 3; ++a) part.low[a] = cell->low[a] + (i >> a & 1 ? part.side : 0);
    if (!push_fine(b, mask, list, &part)) return false;
  }
  return true;
}

static scree_result throw_darts(dart_board* b, const seed_mask* mask, cell_list* cells, random_stream* stream) {
  scree_result result = SCREE_OK;
  for (size_t darts = DARTS_PER_CELL * cells->count; result == SCREE_OK && darts > 0 && cells->count > 0; --darts) {
    const size_t at = (size_t)(random_unit(stream) * (double)cells->count);
    const dart_cell cell = cells->cells[at];
    double p[3];
    for (int a = 0; a < 3; ++a) p[a] = b->min[a] + ((double)cell.low[a] + random_unit(stream) * (double)cell.side) * b->unit;
    if (!seed_mask_has(mask, p) || !is_free(b, p)) continue;
    result = add(b, p);
    cells->cells[at] = cells->cells[--cells->count];
  }
  return result;
}

/* Cuts what no disc covers into eight, unless it is the last round. */
static bool refine(const dart_board* b, const seed_mask* mask, const cell_list* from, cell_list* to) {
  for (size_t i = 0; i < from->count; ++i)
    for (int k = 0; k < 8; ++k) {
      dart_cell part = {.side = from->cells[i].side / 2};
      for (int a = 0; a < 3; ++a) part.low[a] = from->cells[i].low[a] + (k >> a & 1 ? part.side : 0);
      double middle[3], half;
      middle_of(b, &part, middle, &half);
      if (!is_near(b, mask, &part) || is_covered(b, middle, half)) continue;
      if (!push(to, &part, &b->job->allocator)) return false;
    }
  return true;
}

static scree_result fill(dart_board* b, const seed_mask* mask, uint64_t random_seed) {
  const scree_allocator* allocator = &b->job->allocator;
  random_stream stream = {hash_combine(random_seed, 0xd15c)};
  cell_list cells = {0};
  bool room = true;
  uint32_t count[3];
  for (int a = 0; a < 3; ++a) count[a] = (uint32_t)(mask->size[a] * mask->step / b->unit) + 1;
  for (uint32_t z = 0; room && z < count[2]; ++z)
    for (uint32_t y = 0; room && y < count[1]; ++y)
      for (uint32_t x = 0; room && x < count[0]; ++x)
        room = push_fine(b, mask, &cells, &(dart_cell){{(float)x, (float)y, (float)z}, 1});
  scree_result result = room ? SCREE_OK : SCREE_ERROR_OUT_OF_MEMORY;
  for (int round = 0; result == SCREE_OK && cells.count > 0; ++round) {
    result = throw_darts(b, mask, &cells, &stream);
    if (round + 1 == ROUNDS || result != SCREE_OK) break;
    cell_list finer = {0};
    if (!refine(b, mask, &cells, &finer)) result = SCREE_ERROR_OUT_OF_MEMORY;
    drop(&cells, allocator);
    cells = finer;
  }
  drop(&cells, allocator);
  return result;
}

static double reach_at(const void* user, const double p[3]) {
  const dart_board* b = user;
  return farthest(b, seed_radius_at(b->radius, p));
}

scree_result seeds_poisson(seed_job* job, const seed_radius* radius, uint64_t random_seed) {
  dart_board b = {.job = job, .radius = radius};
  b.low_radius = fmin(radius->radii[0], radius->radii[1]), b.high_radius = fmax(radius->radii[0], radius->radii[1]);
  const double span = radius->ends[1] - radius->ends[0];
  b.slope = span > 0 ? (b.high_radius - b.low_radius) / span : 0;
  seed_mask mask;
  scree_result result = seed_job_mask(job, b.low_radius / 2, b.high_radius, reach_at, &b, &mask);
  if (result != SCREE_OK) return result;
  /* A cell of the coarsest is within one disc, and within two boxes of the mask. */
  b.unit = fmin(b.high_radius * 0.57735026918962576451, 2 * mask.step);
  b.step = sqrt(b.low_radius * b.high_radius);
  double boxes = 1;
  for (int a = 0; a < 3; ++a) b.min[a] = mask.min[a];
  do {
    boxes = 1;
    for (int a = 0; a < 3; ++a) {
      const double count = floor(mask.size[a] * mask.step / b.step) + 1;
      boxes *= count;
      b.size[a] = count < LARGEST_GRID ? (uint32_t)count : LARGEST_GRID;
    }
    if (boxes > LARGEST_GRID) b.step *= 1.25;
  } while (boxes > LARGEST_GRID);
  b.heads = scree_rt_allocate_zeroed(&job->allocator, (size_t)boxes, sizeof *b.heads);
  result = b.heads != NULL ? fill(&b, &mask, random_seed) : SCREE_ERROR_OUT_OF_MEMORY;
  if (result == SCREE_ERROR_OUT_OF_MEMORY) recipe_say(job->error, "seeds: out of memory");
  scree_rt_release(&job->allocator, b.heads, (size_t)boxes, sizeof *b.heads);
  scree_rt_release(&job->allocator, b.next, b.next_capacity, sizeof *b.next);
  seed_mask_free(&mask, &job->allocator);
  return result;
}
