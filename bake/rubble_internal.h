/* Where blocks come to rest: what rubble.c sets up and rubble_settle.c moves. The frame is that of rubble: y up, against gravity.
 */
#ifndef SCREE_RUBBLE_INTERNAL_H
#define SCREE_RUBBLE_INTERNAL_H

#include <scree/frost.h>

#include "random.h"
#include "rubble_dexels.h"
#include "rubble_hull.h"

/* What of a simulation is looked at. */
typedef struct rubble_input {
  const scree_shards_view* view;
  const uint8_t* states;
  const scree_block* blocks;
  const uint32_t* block_shards;
  uint32_t block_count;
  double gravity[3]; /* unit */
} rubble_input;

struct scree_rubble {
  scree_allocator allocator;
  scree_resting_block* blocks;
  uint32_t count, capacity;
};

scree_result rubble_settle(const rubble_input* input, const scree_rubble_desc* desc, scree_rubble** out, scree_error* error);

/* A column under a block that is turned some way. Heights are relative to its centre of mass; the column, to the one it is in. */
typedef struct rubble_cell {
  double low, high;         /* of the hull over the column's middle, and of its corners within the column */
  double mid_low, mid_high; /* over the middle alone; low > high where the middle is not under the hull */
  int32_t column[2];
} rubble_cell;

/* A block's columns, of its hull turned by `turn`, its centre of mass at `part` of a column. */
typedef struct rubble_raster {
  rubble_cell* cells;
  uint32_t count, capacity;
} rubble_raster;

typedef struct rubble_pose {
  int32_t column[2];
  double part[2]; /* 0..1: where in the column */
  double height;
  double turn[4]; /* unit quaternion x, y, z, w */
} rubble_pose;

enum { FLOOD_REACH = 48, FLOOD_SIDE = 2 * FLOOD_REACH + 1 };

/* Columns about a block's own, on its way out. */
typedef struct rubble_flood {
  uint8_t seen[FLOOD_SIDE * FLOOD_SIDE];
  uint16_t queue[FLOOD_SIDE * FLOOD_SIDE];
} rubble_flood;

typedef struct rubble_mover {
  const dexels* solid;
  const dexels* rock; /* what stands, without blocks: no centre of mass goes through it */
  const rubble_hull* hull;
  rubble_flood* flood;
  double limit;             /* no centre of mass comes to rest higher: where it was */
  double slope;             /* tangent at which this block still moves */
  double give;              /* what a block may be in others while it moves */
  rubble_raster rasters[2]; /* of the pose; of what is tried */
  random_stream stream;
} rubble_mover;

/* Moves a block from where it was until it rests, nowhere higher. push: in the frame of rubble. Returns false when it rolled off
 * the grid, and where it has no way out of the rock but up. */
bool rubble_move(rubble_mover* mover, rubble_pose* pose, const double push[3]);

/* Fills rasters[0] for a pose. */
void rubble_rasterise(const rubble_mover* mover, const double turn[4], const double part[2], rubble_raster* out);

typedef enum rubble_fit { FIT_FREE, FIT_BLOCKED, FIT_OUT } rubble_fit;

/* Whether a block fits at a place, and how high it lies when it drops from there. Where that is `enough` or more it is blocked: the
 * caller has better, and need not wait for the rest. */
rubble_fit rubble_fits(const rubble_mover* m, const rubble_raster* raster, const int32_t column[2], double height, double enough,
                       double* rest);

/* Out of the rock that it was part of: to the nearest place at its height or below that it fits in and that its centre of mass can
 * reach there through air or other blocks, rather towards its push; then down to what lies below. Returns false where there is
 * none. In rubble_exit.c, as the next. */
bool rubble_leave(const rubble_mover* m, rubble_pose* pose, const double push[3]);

/* Whether no rock is between two columns at a height. */
bool rubble_clear(const rubble_mover* m, const int32_t from[2], const int32_t to[2], double height);

enum { RUBBLE_DIRECTIONS = 8 };
extern const int32_t rubble_directions[RUBBLE_DIRECTIONS][2]; /* by angle, 45 degrees apart */

void rubble_rotate(const double turn[4], const double from[3], double out[3]);

#endif
