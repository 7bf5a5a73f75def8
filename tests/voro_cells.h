/* Voro++ (Rycroft 2009) as judge and reference of our cells. */
#ifndef VORO_CELLS_H
#define VORO_CELLS_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define VORO_WALL UINT32_C(0x80000000) /* + 0..5: sides of the box; + 6 ..: the planes */

typedef struct voro_cells {
  double* volumes;           /* of each seed; 0 = no cell */
  uint32_t* neighbour_first; /* seed_count + 1 */
  uint32_t* neighbours;      /* rising */
} voro_cells;

/* planes: plane_count of normal x, y, z and offset; free with voro_cells_free. Ends the program where memory is short. */
void voro_cells_make(const double min[3], const double max[3], const double (*planes)[4], uint32_t plane_count, const double* seeds,
                     uint32_t seed_count, voro_cells* out);
void voro_cells_free(voro_cells* cells);

#ifdef __cplusplus
}
#endif

#endif
