#include "stability_twin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void stability_twin_levels(const stability_twin* rule, const double* lives, const uint8_t* supported, uint32_t* level) {
  for (uint32_t i = 0; i < rule->view->shard_count; ++i) level[i] = supported[i] ? 0 : UINT32_MAX;
  for (uint32_t d = 0;; ++d) {
    bool more = false;
    for (uint32_t l = 0; l < rule->view->interior_link_count; ++l) {
      const uint32_t* ends = rule->view->links[l].shards;
      if (!(lives[l] > 0)) continue;
      for (int side = 0; side < 2; ++side)
        if (level[ends[side]] == d && level[ends[1 - side]] == UINT32_MAX) {
          level[ends[1 - side]] = d + 1;
          more = true;
        }
    }
    if (!more) return;
  }
}

/* Adds life * (|x|^2 E - x x^T) over a link, by the midpoints of edges of triangles, which is exact for squares of places. */
static void second_moments(const stability_twin* rule, uint32_t l, double life, const double c[3], double j[3][3]) {
  const scree_shards_view* v = rule->view;
  for (uint32_t p = 0; p < v->links[l].polygon_count; ++p) {
    const scree_polygon* polygon = &v->polygons[v->links[l].first_polygon + p];
    const uint32_t* corners = v->corners + polygon->first_corner;
    for (uint32_t i = 1; i + 1 < polygon->corner_count; ++i) {
      const double* t[3] = {v->vertices + 3 * corners[0], v->vertices + 3 * corners[i], v->vertices + 3 * corners[i + 1]};
      double e[3], f[3];
      for (int a = 0; a < 3; ++a) {
        e[a] = t[1][a] - t[0][a];
        f[a] = t[2][a] - t[0][a];
      }
      const double n[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
      double area = 0; /* below 0 in the hollows of a polygon */
      for (int k = 0; k < 3; ++k) area += n[k] * v->links[l].normal[k] / 2;
      for (int m = 0; m < 3; ++m) {
        double x[3], square = 0;
        for (int a = 0; a < 3; ++a) {
          x[a] = (t[m][a] + t[(m + 1) % 3][a]) / 2 - c[a];
          square += x[a] * x[a];
        }
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) j[a][b] += life * area / 3 * ((a == b ? square : 0) - x[a] * x[b]);
      }
    }
  }
}

static void solve(double j[3][3], const double m[3], double out[3]) {
  double rows[3][4];
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) rows[a][b] = j[a][b];
    rows[a][3] = m[a];
  }
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      if (b == a) continue;
      const double factor = rows[b][a] / rows[a][a];
      for (int c = 0; c < 4; ++c) rows[b][c] -= factor * rows[a][c];
    }
  for (int a = 0; a < 3; ++a) out[a] = rows[a][3] / rows[a][a];
}

/* Whether the group in `group` (1 for each of its shards) breaks off by its links to level d - 1. */
static bool breaks(const stability_twin* rule, const double* lives, const uint32_t* level, uint32_t d, const uint8_t* group) {
  const scree_shards_view* v = rule->view;
  double volume = 0, mass_centre[3] = {0}, area = 0, c[3] = {0}, j[3][3] = {{0}};
  for (uint32_t i = 0; i < v->shard_count; ++i) {
    if (!group[i]) continue;
    volume += v->shards[i].volume;
    for (int a = 0; a < 3; ++a) mass_centre[a] += v->shards[i].volume * v->shards[i].centroid[a];
  }
  for (int pass = 0; pass < 3; ++pass) {
    double t[3] = {0}, weight[3], length = 0;
    for (int a = 0; a < 3; ++a) length += rule->gravity[a] * rule->gravity[a];
    for (int a = 0; a < 3; ++a) weight[a] = 9.81 * rule->density * volume * rule->gravity[a] / sqrt(length);
    if (pass == 2) {
      const double trace = j[0][0] + j[1][1] + j[2][2];
      for (int a = 0; a < 3; ++a) j[a][a] += 1e-9 * trace;
      double arm[3];
      for (int a = 0; a < 3; ++a) arm[a] = mass_centre[a] / volume - c[a];
      const double m[3] = {arm[1] * weight[2] - arm[2] * weight[1], arm[2] * weight[0] - arm[0] * weight[2],
                           arm[0] * weight[1] - arm[1] * weight[0]};
      solve(j, m, t);
    }
    for (uint32_t l = 0; l < v->interior_link_count; ++l) {
      const scree_link* link = &v->links[l];
      if (!(lives[l] > 0)) continue;
      const bool first = group[link->shards[0]] && level[link->shards[1]] == d - 1;
      const bool second = group[link->shards[1]] && level[link->shards[0]] == d - 1;
      if (!first && !second) continue;
      if (pass == 0) {
        area += lives[l] * link->area;
        for (int a = 0; a < 3; ++a) c[a] += lives[l] * link->area * link->centroid[a];
      } else if (pass == 1) {
        second_moments(rule, l, lives[l], c, j);
      } else {
        for (uint32_t p = 0; p < link->polygon_count; ++p) {
          const scree_polygon* polygon = &v->polygons[link->first_polygon + p];
          for (uint32_t k = 0; k < polygon->corner_count; ++k) {
            double r[3], pull[3], s_k = 0, square = 0;
            for (int a = 0; a < 3; ++a) r[a] = v->vertices[3 * v->corners[polygon->first_corner + k] + (uint32_t)a] - c[a];
            const double turn[3] = {t[1] * r[2] - t[2] * r[1], t[2] * r[0] - t[0] * r[2], t[0] * r[1] - t[1] * r[0]};
            for (int a = 0; a < 3; ++a) {
              pull[a] = weight[a] / area + turn[a];
              s_k += pull[a] * (first ? -link->normal[a] : link->normal[a]);
              square += pull[a] * pull[a];
            }
            const double shear = sqrt(fmax(0, square - s_k * s_k));
            if (s_k + shear > rule->strength || -s_k > rule->compression * rule->strength) return true;
          }
        }
      }
    }
    if (pass == 0)
      for (int a = 0; a < 3; ++a) c[a] /= area;
  }
  return false;
}

static void flood(const stability_twin* rule, const double* lives, const uint32_t* level, uint32_t d, uint32_t start,
                  uint8_t* group) {
  memset(group, 0, rule->view->shard_count);
  group[start] = 1;
  for (bool more = true; more;) {
    more = false;
    for (uint32_t l = 0; l < rule->view->interior_link_count; ++l) {
      const uint32_t* ends = rule->view->links[l].shards;
      if (!(lives[l] > 0) || level[ends[0]] < d || level[ends[1]] < d) continue;
      if (level[ends[0]] == UINT32_MAX || level[ends[1]] == UINT32_MAX || group[ends[0]] == group[ends[1]]) continue;
      group[ends[0]] = group[ends[1]] = 1;
      more = true;
    }
  }
}

/* Of level d, one that breaks; false where all hold. group: 1 for each of its shards. */
static bool find_weak(const stability_twin* rule, const double* lives, const uint32_t* level, uint32_t d, uint8_t* group) {
  const uint32_t count = rule->view->shard_count;
  uint8_t* seen = calloc(count, 1);
  if (seen == NULL) abort();
  bool weak = false;
  for (uint32_t i = 0; i < count && !weak; ++i) {
    if (level[i] != d || seen[i] != 0) continue;
    flood(rule, lives, level, d, i, group);
    for (uint32_t k = 0; k < count; ++k) seen[k] |= group[k];
    weak = breaks(rule, lives, level, d, group);
  }
  free(seen);
  return weak;
}

uint32_t stability_twin_weigh(const stability_twin* rule, const uint8_t* supported, double* lives) {
  const scree_shards_view* v = rule->view;
  uint32_t* level = calloc(v->shard_count, sizeof *level);
  uint8_t* group = calloc(v->shard_count, 1);
  if (level == NULL || group == NULL) abort();
  uint32_t broken = 0;
  for (bool again = true; again;) {
    again = false;
    stability_twin_levels(rule, lives, supported, level);
    uint32_t most = 0;
    for (uint32_t i = 0; i < v->shard_count; ++i)
      if (level[i] != UINT32_MAX && level[i] > most) most = level[i];
    for (uint32_t d = most; d > 0 && !again; --d) {
      if (!find_weak(rule, lives, level, d, group)) continue;
      for (uint32_t l = 0; l < v->interior_link_count; ++l)
        if (group[v->links[l].shards[0]] != group[v->links[l].shards[1]]) lives[l] = 0;
      ++broken;
      again = true;
    }
  }
  free(level);
  free(group);
  return broken;
}
