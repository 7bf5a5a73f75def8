#include "surface_cubes.h"

#include <stdbool.h>
#include <string.h>

/* The edges of face 2 * axis + side, in order around it, so that edges k and k + 1 share corner k of the face. */
typedef struct cube_face {
  uint8_t corner[4], edge[4];
} cube_face;

static uint32_t edge_between(uint32_t a, uint32_t b) {
  for (uint32_t edge = 0;; ++edge)
    if ((cube_edge_low(edge) == a && cube_edge_high(edge) == b) || (cube_edge_low(edge) == b && cube_edge_high(edge) == a))
      return edge;
}

static void fill_face(uint32_t face, cube_face* out) {
  const uint32_t axis = face >> 1, u = 1u << (axis + 1) % 3, v = 1u << (axis + 2) % 3, at = (face & 1) << axis;
  const uint32_t corners[4] = {at, at | u, at | u | v, at | v};
  for (uint32_t k = 0; k < 4; ++k) {
    out->corner[k] = (uint8_t)corners[k];
    out->edge[k] = (uint8_t)edge_between(corners[(k + 3) & 3], corners[k]);
  }
}

static uint8_t find(const uint8_t* parent, uint8_t edge) {
  while (parent[edge] != edge) edge = parent[edge];
  return edge;
}

/* The lower edge becomes the root, so that the order of pieces is that of their first edges. */
static void join(uint8_t* parent, uint8_t a, uint8_t b) {
  a = find(parent, a), b = find(parent, b);
  if (a < b)
    parent[b] = a;
  else
    parent[a] = b;
}

/* other: the face that is cut the other way, or CUBE_NO_FACE. */
static void fill_pieces(const cube_face* faces, uint32_t inside, uint32_t other, uint8_t piece[CUBE_EDGES], uint8_t* count) {
  uint8_t parent[CUBE_EDGES];
  for (uint8_t edge = 0; edge < CUBE_EDGES; ++edge) parent[edge] = edge;
  for (uint32_t f = 0; f < CUBE_FACES; ++f) {
    uint32_t bits = 0, crossed = 0;
    for (uint32_t k = 0; k < 4; ++k) bits |= (inside >> faces[f].corner[k] & 1) << k;
    for (uint32_t k = 0; k < 4; ++k) crossed |= ((bits >> k ^ bits >> ((k + 3) & 3)) & 1) << k;
    if (crossed == 15) { /* around each inside corner, or each outside one */
      const uint32_t around = f == other ? ~bits : bits;
      for (uint32_t k = 0; k < 4; ++k)
        if (around >> k & 1) join(parent, faces[f].edge[k], faces[f].edge[(k + 1) & 3]);
    } else {
      uint8_t first = CUBE_EDGES;
      for (uint32_t k = 0; k < 4; ++k)
        if (crossed >> k & 1) {
          if (first < CUBE_EDGES) join(parent, first, faces[f].edge[k]);
          first = faces[f].edge[k];
        }
    }
  }
  *count = 0;
  for (uint8_t edge = 0; edge < CUBE_EDGES; ++edge) {
    const bool is_crossed = ((inside >> cube_edge_low(edge) ^ inside >> cube_edge_high(edge)) & 1) != 0;
    if (!is_crossed)
      piece[edge] = 0;
    else
      piece[edge] = parent[edge] == edge ? (*count)++ : piece[find(parent, edge)];
  }
}

void surface_cubes_fill(surface_cubes* out) {
  cube_face faces[CUBE_FACES];
  for (uint32_t f = 0; f < CUBE_FACES; ++f) fill_face(f, &faces[f]);
  memset(out, 0, sizeof *out);
  for (uint32_t inside = 0; inside < 256; ++inside) {
    for (uint32_t edge = 0; edge < CUBE_EDGES; ++edge)
      out->crossed[inside] |= (uint16_t)(((inside >> cube_edge_low(edge) ^ inside >> cube_edge_high(edge)) & 1) << edge);
    fill_pieces(faces, inside, CUBE_NO_FACE, out->piece[0][inside], &out->pieces[0][inside]);
    out->pinching[inside] = CUBE_NO_FACE;
    for (uint32_t f = 0; f < CUBE_FACES; ++f) {
      const uint8_t *corner = faces[f].corner, *edge = faces[f].edge;
      const uint32_t a = inside >> corner[0] & 1, b = inside >> corner[1] & 1;
      const bool diagonal = a != b && a == (inside >> corner[2] & 1) && b == (inside >> corner[3] & 1);
      if (diagonal && out->piece[0][inside][edge[0]] == out->piece[0][inside][edge[2]]) out->pinching[inside] = (uint8_t)f;
    }
    fill_pieces(faces, inside, out->pinching[inside], out->piece[1][inside], &out->pieces[1][inside]);
  }
}
