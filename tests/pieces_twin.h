/* Judges pieces of cells, in the plainest way. */
#ifndef PIECES_TWIN_H
#define PIECES_TWIN_H

#include "shard_pieces.h"

typedef struct pieces_facts {
  uint32_t open_edges;  /* directed edges of a cell without their opposite, or there twice */
  uint32_t disorder;    /* pieces out of order, corners out of range */
  uint32_t surfaces;    /* closed surfaces of all cells: those that share an edge */
  uint32_t hollows;     /* of these: inside out */
  uint32_t cells;       /* with anything in them */
  double worst_closure; /* |sum of area vectors| / sum of areas, over surfaces */
  double volume_error;  /* of the sum of all volumes, relative to the mesh */
  double surface_error; /* likewise of areas */
  double least_volume;  /* of a cell */
} pieces_facts;

/* cell_volumes: of each seed; may be NULL. Ends the program where memory is short. */
void pieces_judge(const shard_input* input, const shard_pieces* pieces, double* cell_volumes, pieces_facts* out);

/* The volume of the solid in a cell: the tetrahedra of all triangles, each cut by all bisectors. */
double cell_volume_twin(const shard_input* input, uint32_t seed);

/* Of the mesh. */
double input_volume(const shard_input* input);

#endif
