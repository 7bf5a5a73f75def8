/* One query, prepared, and the kernels that run it. */
#ifndef SCREE_QUERY_KERNEL_H
#define SCREE_QUERY_KERNEL_H

#include "field_tables.h"
#include "support_program.h"

/* Cells of a box, a byte each: SCREE_CELL_FULL where all rocks that the field has in a cell exist, else how many are known to. */
typedef struct cell_grid {
  uint8_t* cells;
  int64_t low[3], high[3];
  size_t row, slice; /* bytes from one y to the next, from one z to the next */
} cell_grid;

#define SCREE_CELL_FULL 255

static inline uint8_t* grid_cell(const cell_grid* grid, const int64_t cell[3]) {
  return grid->cells + (size_t)(cell[2] - grid->low[2]) * grid->slice + (size_t)(cell[1] - grid->low[1]) * grid->row +
         (size_t)(cell[0] - grid->low[0]);
}

/* Notes one more rock of a cell that has `all` of them. */
static inline void grid_add(uint8_t* cell, uint32_t all) {
  if (*cell != SCREE_CELL_FULL && ++*cell == all) *cell = SCREE_CELL_FULL;
}

typedef struct query_run {
  const scree_field* field;
  const scree_support* support;
  double test_base[3];               /* centre of cell (0, 0, 0) in the support's space */
  double out_base[3];                /* the same relative to the query's origin */
  int64_t cell_low[3], cell_high[3]; /* cells that belong to the query: low <= c < high */
  int32_t cube_low[3], cube_high[3]; /* cubes that hold them */
  float slope;                       /* 1 - 2 threshold: a rock exists where distance <= slope * mean radius */
  float offset_min, offset_max;      /* of slope * mean radius over all rocks */
  float floor;                       /* shell: and distance > floor; -infinity without */
  float margin;                      /* more than rounding can move any distance of this query */
  float relevant_low, relevant_high; /* distances outside are all alike to the query */
  const cell_grid* deep;     /* or NULL: rocks below `floor` exist, are noted here, and are not delivered, but for those that
                                no burial hides */
  bool whole;                /* evaluate whole programs everywhere */
  scree_instance* instances; /* NULL: only count */
  scree_id* ids;             /* or NULL */
  uint64_t capacity;
  uint64_t count;
} query_run;

/* The bits of the answer are the same from all kernels. WHOLE is the best one, without pruning: what pruning is measured against.
 */
typedef enum query_kernel { QUERY_KERNEL_BEST = 0, QUERY_KERNEL_PLAIN = 1, QUERY_KERNEL_WHOLE = 2 } query_kernel;

/* scree_query_count and scree_query_fill with a chosen kernel. */
scree_result scree_rt_query_count(const scree_query_desc* desc, query_kernel kernel, uint64_t* count);
scree_result scree_rt_query_fill(const scree_query_desc* desc, query_kernel kernel, scree_instance* instances, scree_id* ids,
                                 uint64_t capacity, uint64_t* count);

/* A query of the cells in [low, high), which may reach past the int32 cubes only where the support does not. */
typedef struct cell_query {
  const scree_field* field;
  const scree_support* support;
  double origin[3]; /* as in scree_query_desc, and so on */
  float threshold;
  float depth;           /* rocks as deep as this or deeper do not exist; 0 = they do */
  const cell_grid* deep; /* or NULL: rocks as deep as `depth` are noted here, as in query_run; it holds [low, high) */
  bool outside;          /* only rocks whose centroids are more than `above` outside, metres; `depth` is not looked at */
  float above;
  int64_t low[3], high[3];
} cell_query;

/* Both arrays or none, as in scree_query_fill. */
scree_result scree_rt_query_cells(const cell_query* query, scree_instance* instances, scree_id* ids, uint64_t capacity,
                                  uint64_t* count);

/* The first cell whose centre is at or past `bound`, both relative to the centre of cell 0; at most 1e15 either way. */
int64_t scree_rt_query_first_cell(double bound, double cell_size);

void scree_rt_query_run_plain(query_run* run);
#ifdef SCREE_WIDE_KERNELS
void scree_rt_query_run_avx2(query_run* run);
#endif

#endif
