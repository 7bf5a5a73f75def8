#include "pieces_twin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct cell_edge {
  uint32_t from, to, piece;
} cell_edge;

static int by_ends(const void* a, const void* b) {
  const cell_edge *x = a, *y = b;
  if (x->from != y->from) return x->from < y->from ? -1 : 1;
  if (x->to != y->to) return x->to < y->to ? -1 : 1;
  return x->piece < y->piece ? -1 : x->piece > y->piece;
}

static uint32_t root_of(uint32_t* parents, uint32_t at) {
  while (parents[at] != at) at = parents[at] = parents[parents[at]];
  return at;
}

/* Area vector times 2, and volume times 6 around `origin`. */
static double measure(const shard_pieces* p, const shard_piece* piece, const double origin[3], double area[3]) {
  const uint32_t* corners = &p->corners[piece->first_corner];
  double volume = 0;
  area[0] = area[1] = area[2] = 0;
  for (uint32_t k = 1; k + 1 < piece->corner_count; ++k) {
    double d[3][3];
    const uint32_t of[3] = {corners[0], corners[k], corners[k + 1]};
    for (int c = 0; c < 3; ++c)
      for (int a = 0; a < 3; ++a) d[c][a] = p->vertices[3 * (size_t)of[c] + (size_t)a] - origin[a];
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      area[a] += (d[1][b] - d[0][b]) * (d[2][c] - d[0][c]) - (d[1][c] - d[0][c]) * (d[2][b] - d[0][b]);
      volume += d[0][a] * (d[1][b] * d[2][c] - d[1][c] * d[2][b]);
    }
  }
  return volume;
}

double input_volume(const shard_input* input) {
  double sum = 0;
  for (size_t t = 0; t < input->triangle_count; ++t) {
    double d[3][3];
    for (size_t c = 0; c < 3; ++c)
      for (size_t a = 0; a < 3; ++a)
        d[c][a] = input->positions[3 * (size_t)input->indices[3 * t + c] + a] - input->positions[3 * (size_t)input->indices[0] + a];
    for (int a = 0; a < 3; ++a) sum += d[0][a] * (d[1][(a + 1) % 3] * d[2][(a + 2) % 3] - d[1][(a + 2) % 3] * d[2][(a + 1) % 3]);
  }
  return sum / 6;
}

static double input_area(const shard_input* input) {
  double sum = 0;
  for (size_t t = 0; t < input->triangle_count; ++t) {
    double u[3], v[3], n = 0;
    for (size_t a = 0; a < 3; ++a) {
      const double at = input->positions[3 * (size_t)input->indices[3 * t] + a];
      u[a] = input->positions[3 * (size_t)input->indices[3 * t + 1] + a] - at;
      v[a] = input->positions[3 * (size_t)input->indices[3 * t + 2] + a] - at;
    }
    for (int a = 0; a < 3; ++a) {
      const double one = u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3];
      n += one * one;
    }
    sum += sqrt(n);
  }
  return sum;
}

void pieces_judge(const shard_input* input, const shard_pieces* p, double* cell_volumes, pieces_facts* out) {
  *out = (pieces_facts){.least_volume = INFINITY};
  uint32_t* of_cell = calloc((size_t)input->seed_count + 1, sizeof *of_cell);
  for (uint32_t k = 0; k < p->piece_count; ++k) {
    const shard_piece* piece = &p->pieces[k];
    bool bad = piece->cells[0] >= input->seed_count || piece->cells[1] <= piece->cells[0] || piece->corner_count < 3;
    bad = bad || (piece->cells[1] == PIECE_OUTSIDE ? piece->triangle >= input->triangle_count
                                                   : piece->cells[1] >= input->seed_count || piece->triangle != UINT32_MAX);
    bad = bad || piece->first_corner > p->corner_count || piece->corner_count > p->corner_count - piece->first_corner;
    for (uint32_t c = 0; !bad && c < piece->corner_count; ++c) bad = p->corners[piece->first_corner + c] >= p->vertex_count;
    if (k > 0) {
      const shard_piece* before = piece - 1;
      const uint32_t a[3] = {before->cells[0], before->cells[1], before->triangle},
                     b[3] = {piece->cells[0], piece->cells[1], piece->triangle};
      int order = 0;
      for (int c = 0; c < 3 && order == 0; ++c) order = a[c] < b[c] ? -1 : a[c] > b[c];
      bad = bad || order > 0;
    }
    if (bad) {
      ++out->disorder;
      free(of_cell);
      return;
    }
    for (int side = 0; side < 2; ++side)
      if (piece->cells[side] != PIECE_OUTSIDE) ++of_cell[piece->cells[side] + 1];
  }
  for (uint32_t k = 0; k < input->seed_count; ++k) of_cell[k + 1] += of_cell[k];
  uint32_t *order = calloc((size_t)of_cell[input->seed_count] + 1, sizeof *order),
           *fill = calloc((size_t)input->seed_count + 1, sizeof *fill),
           *parents = calloc((size_t)p->piece_count + 1, sizeof *parents);
  double(*sums)[5] = calloc((size_t)p->piece_count + 1, sizeof *sums); /* of surfaces: area vector, area, volume */
  cell_edge* edges = calloc(2 * (size_t)p->corner_count + 1, sizeof *edges);
  if (order == NULL || fill == NULL || parents == NULL || sums == NULL || edges == NULL) abort();
  memcpy(fill, of_cell, (size_t)input->seed_count * sizeof *fill);
  for (uint32_t k = 0; k < p->piece_count; ++k)
    for (int side = 0; side < 2; ++side)
      if (p->pieces[k].cells[side] != PIECE_OUTSIDE) order[fill[p->pieces[k].cells[side]]++] = k;
  double volume = 0, area = 0;
  for (uint32_t seed = 0; seed < input->seed_count; ++seed) {
    const uint32_t first = of_cell[seed], end = of_cell[seed + 1];
    if (cell_volumes != NULL) cell_volumes[seed] = 0;
    if (first == end) continue;
    ++out->cells;
    size_t count = 0;
    for (uint32_t k = first; k < end; ++k) {
      const shard_piece* piece = &p->pieces[order[k]];
      const bool turned = piece->cells[0] != seed;
      parents[order[k]] = order[k];
      memset(sums[order[k]], 0, sizeof *sums);
      for (uint32_t c = 0; c < piece->corner_count; ++c) {
        const uint32_t a = p->corners[piece->first_corner + c], b = p->corners[piece->first_corner + (c + 1) % piece->corner_count];
        edges[count++] = (cell_edge){turned ? b : a, turned ? a : b, order[k]};
      }
    }
    qsort(edges, count, sizeof *edges, by_ends);
    for (size_t k = 0; k < count; ++k) {
      if (k > 0 && edges[k].from == edges[k - 1].from && edges[k].to == edges[k - 1].to) ++out->open_edges;
      size_t low = 0, high = count;
      while (low < high) {
        const size_t middle = (low + high) / 2;
        const cell_edge* e = &edges[middle];
        if (e->from < edges[k].to || (e->from == edges[k].to && e->to < edges[k].from))
          low = middle + 1;
        else
          high = middle;
      }
      if (low == count || edges[low].from != edges[k].to || edges[low].to != edges[k].from) {
        ++out->open_edges;
        continue;
      }
      parents[root_of(parents, edges[k].piece)] = root_of(parents, edges[low].piece);
    }
    double cell_volume = 0;
    for (uint32_t k = first; k < end; ++k) {
      const shard_piece* piece = &p->pieces[order[k]];
      const double sign = piece->cells[0] == seed ? 1 : -1;
      double a[3];
      const double six = measure(p, piece, &input->seeds[3 * (size_t)seed], a),
                   size = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]);
      double* sum = sums[root_of(parents, order[k])];
      for (int axis = 0; axis < 3; ++axis) sum[axis] += sign * a[axis];
      sum[3] += size;
      sum[4] += sign * six / 6;
      if (piece->cells[1] == PIECE_OUTSIDE) area += size;
    }
    for (uint32_t k = first; k < end; ++k) {
      if (parents[order[k]] != order[k]) continue;
      const double* sum = sums[order[k]];
      const double closure = sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / sum[3];
      ++out->surfaces;
      if (sum[4] < 0) ++out->hollows;
      if (sum[3] > 0 && closure > out->worst_closure) out->worst_closure = closure;
      cell_volume += sum[4];
    }
    if (cell_volumes != NULL) cell_volumes[seed] = cell_volume;
    if (cell_volume < out->least_volume) out->least_volume = cell_volume;
    volume += cell_volume;
  }
  const double whole = input_volume(input), skin = input_area(input);
  out->volume_error = fabs(volume - whole) / fabs(whole);
  out->surface_error = fabs(area - skin) / skin;
  free(of_cell);
  free(order);
  free(fill);
  free(parents);
  free(sums);
  free(edges);
}

/* --- The volume of a cell, once more. --- */

static double tetrahedron(const double t[4][3]) {
  double d[3][3], sum = 0;
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < 3; ++a) d[c][a] = t[c + 1][a] - t[0][a];
  for (int a = 0; a < 3; ++a) sum += d[0][a] * (d[1][(a + 1) % 3] * d[2][(a + 2) % 3] - d[1][(a + 2) % 3] * d[2][(a + 1) % 3]);
  return fabs(sum) / 6;
}

/* Of a tetrahedron relative to the seed, what lies nearer to it than to the seeds from `next` on. */
static double cut_volume(const shard_input* input, uint32_t seed, uint32_t next, double t[4][3]) {
  for (; next < input->seed_count; ++next) {
    if (next == seed) continue;
    double side[4];
    int in[4], out[4], ins = 0, outs = 0;
    for (int c = 0; c < 4; ++c) {
      side[c] = 0;
      for (size_t a = 0; a < 3; ++a) {
        const double n = input->seeds[3 * (size_t)next + a] - input->seeds[3 * (size_t)seed + a];
        side[c] += n * n - 2 * n * t[c][a];
      }
      if (side[c] >= 0)
        in[ins++] = c;
      else
        out[outs++] = c;
    }
    if (outs == 0) continue;
    if (ins == 0) return 0;
    double cuts[4][4][3]; /* from a corner that is in to one that is out */
    for (int i = 0; i < ins; ++i)
      for (int o = 0; o < outs; ++o)
        for (int a = 0; a < 3; ++a) {
          const double share = side[in[i]] / (side[in[i]] - side[out[o]]);
          cuts[i][o][a] = t[in[i]][a] + share * (t[out[o]][a] - t[in[i]][a]);
        }
    const double* parts[3][4];
    int count = 0;
    if (ins == 1) {
      const double* one[4] = {t[in[0]], cuts[0][0], cuts[0][1], cuts[0][2]};
      memcpy(parts[count++], one, sizeof one);
    } else {
      /* A prism: triangles (p0, p1, p2) and (q0, q1, q2), with edges between those of one number. */
      const double *p[3], *q[3];
      if (ins == 3) {
        for (int c = 0; c < 3; ++c) p[c] = t[in[c]], q[c] = cuts[c][0];
      } else {
        p[0] = t[in[0]], p[1] = cuts[0][0], p[2] = cuts[0][1];
        q[0] = t[in[1]], q[1] = cuts[1][0], q[2] = cuts[1][1];
      }
      const double* three[3][4] = {{p[0], p[1], p[2], q[0]}, {p[1], p[2], q[0], q[1]}, {p[2], q[0], q[1], q[2]}};
      memcpy(parts, three, sizeof three);
      count = 3;
    }
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      double part[4][3];
      for (int c = 0; c < 4; ++c) memcpy(part[c], parts[k][c], sizeof part[c]);
      sum += cut_volume(input, seed, next + 1, part);
    }
    return sum;
  }
  return tetrahedron((const double(*)[3])t);
}

double cell_volume_twin(const shard_input* input, uint32_t seed) {
  double sum = 0;
  for (size_t t = 0; t < input->triangle_count; ++t) {
    double corners[4][3] = {{0}}, sign = 0;
    for (size_t c = 0; c < 3; ++c)
      for (size_t a = 0; a < 3; ++a)
        corners[c + 1][a] = input->positions[3 * (size_t)input->indices[3 * t + c] + a] - input->seeds[3 * (size_t)seed + a];
    for (int a = 0; a < 3; ++a)
      sign +=
          corners[1][a] * (corners[2][(a + 1) % 3] * corners[3][(a + 2) % 3] - corners[2][(a + 2) % 3] * corners[3][(a + 1) % 3]);
    const double volume = cut_volume(input, seed, 0, corners);
    sum += sign < 0 ? -volume : volume;
  }
  return sum;
}
