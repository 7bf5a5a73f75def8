/* report_rubble RECIPE...: how what fell lies at the last two times of recipes of shards, a line each. Looked at with columns three
 * times as fine as those that it was laid with, and with the blocks' own shape instead of their hull: the two share no code. Shares
 * of blocks: higher than they were; taller than 1.5 times their largest width; with what bears them all on one side (leaning
 * against walls, too); above two fifths of the cliff's height; floating by a tenth of their size; with 0.15 of their volume in what
 * stands, in other blocks. */
#include <math.h>
#include <scree/shard_recipe.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "random.h"
#include "shard_weather.h"
#include "start_files.h"

typedef struct span {
  double low, high;
  uint32_t owner; /* a block, or ROCK or GROUND */
} span;

enum { ROCK = 0x7fffffff, GROUND = 0x7ffffffe }; /* beside numbers of blocks */

typedef struct column {
  span* spans;
  uint32_t count, capacity;
} column;

typedef struct grid {
  double origin[2], size;
  uint32_t count[2];
  column* columns;
} grid;

static void* must(void* memory) {
  if (memory == NULL) exit(2);
  return memory;
}

static column* column_at(grid* g, int64_t i, int64_t k) {
  return i < 0 || k < 0 || i >= g->count[0] || k >= g->count[1] ? NULL : &g->columns[(size_t)i + g->count[0] * (size_t)k];
}

static void add_span(column* c, double low, double high, uint32_t owner) {
  if (c->count == c->capacity) c->spans = must(realloc(c->spans, (c->capacity = 2 * c->capacity + 2) * sizeof *c->spans));
  c->spans[c->count++] = (span){low, high, owner};
}

static void rotate(const double q[4], const double p[3], double out[3]) {
  const double t[3] = {2 * (q[1] * p[2] - q[2] * p[1]), 2 * (q[2] * p[0] - q[0] * p[2]), 2 * (q[0] * p[1] - q[1] * p[0])};
  out[0] = p[0] + q[3] * t[0] + q[1] * t[2] - q[2] * t[1];
  out[1] = p[1] + q[3] * t[1] + q[2] * t[0] - q[0] * t[2];
  out[2] = p[2] + q[3] * t[2] + q[0] * t[1] - q[1] * t[0];
}

/* One shard as spans of its columns, moved as its block was: where the line up the middle is inside its polygons. */
static void add_shard(grid* g, const scree_shards_view* v, uint32_t s, const double from[3], const scree_resting_block* at,
                      uint32_t owner) {
  typedef struct hit {
    uint32_t column;
    double height;
  } hit;
  static hit* hits;
  static uint32_t capacity;
  uint32_t count = 0;
  double corners[256][3];
  const scree_shard* shard = &v->shards[s];
  for (uint32_t k = 0; k < shard->link_count; ++k) {
    const scree_link* link = &v->links[v->shard_links[shard->first_link + k]];
    for (uint32_t p = link->first_polygon; p < link->first_polygon + link->polygon_count; ++p) {
      const scree_polygon* polygon = &v->polygons[p];
      const uint32_t n = polygon->corner_count < 256 ? polygon->corner_count : 256;
      double low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, area[3] = {0, 0, 0};
      for (uint32_t c = 0; c < n; ++c) {
        const double* w = v->vertices + 3 * (size_t)v->corners[polygon->first_corner + c];
        double local[3] = {w[0] - from[0], w[1] - from[1], w[2] - from[2]};
        if (at != NULL) {
          rotate(at->rotation, local, corners[c]);
          for (int a = 0; a < 3; ++a) corners[c][a] += at->translation[a];
        } else {
          memcpy(corners[c], w, sizeof corners[c]);
        }
        for (int a = 0; a < 2; ++a) {
          low[a] = fmin(low[a], corners[c][2 * a]);
          high[a] = fmax(high[a], corners[c][2 * a]);
        }
      }
      for (uint32_t c = 0; c < n; ++c) {
        const double *a = corners[c], *b = corners[(c + 1) % n], *o = corners[0];
        for (int axis = 0; axis < 3; ++axis) {
          const int u = (axis + 1) % 3, w = (axis + 2) % 3;
          area[axis] += (a[u] - o[u]) * (b[w] - o[w]) - (a[w] - o[w]) * (b[u] - o[u]);
        }
      }
      const double length = sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
      if (!(fabs(area[1]) > 1e-9 * length) || !(length > 0)) continue;
      const int64_t i0 = (int64_t)floor((low[0] - g->origin[0]) / g->size), i1 = (int64_t)floor((high[0] - g->origin[0]) / g->size);
      const int64_t k0 = (int64_t)floor((low[1] - g->origin[1]) / g->size), k1 = (int64_t)floor((high[1] - g->origin[1]) / g->size);
      for (int64_t kk = k0; kk <= k1; ++kk)
        for (int64_t i = i0; i <= i1; ++i) {
          if (column_at(g, i, kk) == NULL) continue;
          /* Off the middle by odd parts, so that no line meets a lattice's own edges. */
          const double x = g->origin[0] + ((double)i + 0.5013) * g->size, z = g->origin[1] + ((double)kk + 0.5027) * g->size;
          bool in = false;
          for (uint32_t c = 0; c < n; ++c) {
            const double *a = corners[c], *b = corners[(c + 1) % n];
            if ((a[2] <= z) == (b[2] <= z)) continue;
            if (x < a[0] + (z - a[2]) / (b[2] - a[2]) * (b[0] - a[0])) in = !in;
          }
          if (!in) continue;
          if (count == capacity) hits = must(realloc(hits, (capacity = 2 * capacity + 64) * sizeof *hits));
          hits[count++] = (hit){(uint32_t)i + g->count[0] * (uint32_t)kk,
                                corners[0][1] - (area[0] * (x - corners[0][0]) + area[2] * (z - corners[0][2])) / area[1]};
        }
    }
  }
  for (uint32_t a = 1; a < count; ++a) { /* by column, then height */
    const hit moved = hits[a];
    uint32_t b = a;
    for (;
         b > 0 && (hits[b - 1].column > moved.column || (hits[b - 1].column == moved.column && hits[b - 1].height > moved.height));
         --b)
      hits[b] = hits[b - 1];
    hits[b] = moved;
  }
  for (uint32_t a = 0; a + 1 < count;) {
    if (hits[a].column != hits[a + 1].column) {
      ++a;
      continue;
    }
    add_span(&g->columns[hits[a].column], hits[a].height, hits[a + 1].height, owner);
    a += 2;
  }
}

typedef struct totals {
  uint32_t blocks, higher, on_end, floating, sunk, in_rock, unsteady, high_up;
  double gap, overlap, rock_overlap;
} totals;

static void look(const shard_weather* weather, const scree_shard_recipe* recipe, const char* name, uint32_t time) {
  const scree_shard_rubble* rules = &recipe->rubble;
  scree_shards_view v;
  scree_frost_view f;
  const scree_block* blocks;
  const uint32_t* list;
  const scree_resting_block* resting;
  scree_shards_get(weather->shards, &v);
  scree_frost_get(weather->frost, &f);
  const uint32_t fallen = scree_frost_blocks(weather->frost, &blocks, &list);
  scree_rubble_desc desc;
  shard_weather_rubble(weather, &desc);
  scree_rubble* rubble;
  scree_error error;
  if (scree_rubble_create(&desc, &rubble, &error) != SCREE_OK) {
    fprintf(stderr, "%s\n", error.message);
    exit(1);
  }
  const uint32_t count = scree_rubble_get(rubble, &resting);
  const double coarse = rules->resolution > 0 ? rules->resolution : cbrt(v.volume / v.shard_count) / 3;
  grid g = {.size = coarse / 3};
  double low[2] = {v.min[0], v.min[2]}, high[2] = {v.max[0], v.max[2]};
  for (uint32_t i = 0; i < count; ++i)
    for (int a = 0; a < 2; ++a) {
      low[a] = fmin(low[a], resting[i].translation[2 * a]);
      high[a] = fmax(high[a], resting[i].translation[2 * a]);
    }
  for (int a = 0; a < 2; ++a) {
    g.origin[a] = low[a] - 8 * coarse;
    g.count[a] = (uint32_t)((high[a] - low[a] + 16 * coarse) / g.size) + 1;
  }
  g.columns = must(calloc((size_t)g.count[0] * g.count[1], sizeof *g.columns));
  static const double zero[3] = {0, 0, 0};
  for (uint32_t s = 0; s < v.shard_count; ++s)
    if (f.states[s] != SCREE_SHARD_AIR) add_shard(&g, &v, s, zero, NULL, ROCK);
  for (uint32_t c = 0; c < g.count[0] * g.count[1]; ++c) add_span(&g.columns[c], -1e9, rules->ground, GROUND);
  for (uint32_t i = 0; i < count; ++i) {
    const scree_block* b = &blocks[resting[i].block];
    for (uint32_t s = 0; s < b->shard_count; ++s) add_shard(&g, &v, list[b->first_shard + s], b->centroid, &resting[i], i);
  }
  double* gap = must(malloc((count + 1) * sizeof *gap));
  double* bottom = must(malloc((count + 1) * sizeof *bottom));
  double* top = must(malloc((count + 1) * sizeof *top));
  double* volume = must(calloc(count + 1, sizeof *volume));
  double* over = must(calloc(count + 1, sizeof *over));
  double* rock = must(calloc(count + 1, sizeof *rock));
  double(*far)[16] = must(malloc((count + 1) * sizeof *far));
  double(*bear)[16] = must(malloc((count + 1) * sizeof *bear));
  for (uint32_t i = 0; i < count; ++i) {
    gap[i] = bottom[i] = INFINITY;
    top[i] = -INFINITY;
    for (int d = 0; d < 16; ++d) far[i][d] = bear[i][d] = -INFINITY;
  }
  for (int pass = 0; pass < 2; ++pass)
    for (uint32_t k = 0; k < g.count[1]; ++k)
      for (uint32_t ii = 0; ii < g.count[0]; ++ii) {
        const column* c = &g.columns[ii + g.count[0] * k];
        for (uint32_t a = 0; a < c->count; ++a) {
          const uint32_t me = c->spans[a].owner;
          if (me >= GROUND) continue;
          const span* s = &c->spans[a];
          double below = -INFINITY, in_other = 0, in_rock = 0, lowest = s->low;
          for (uint32_t b = 0; b < c->count; ++b) {
            if (c->spans[b].owner == me) {
              if (c->spans[b].low < lowest) lowest = c->spans[b].low;
              continue;
            }
            const span* o = &c->spans[b];
            const double l = fmax(o->low, s->low), h = fmin(o->high, s->high);
            if (h > l) {
              if (o->owner >= GROUND)
                in_rock += h - l;
              else
                in_other += h - l;
            }
            if (o->low <= s->low) below = fmax(below, fmin(o->high, s->low));
          }
          if (lowest < s->low) below = -INFINITY; /* another shard of its own is below */
          const double x = g.origin[0] + (ii + 0.5) * g.size - resting[me].translation[0],
                       z = g.origin[1] + (k + 0.5) * g.size - resting[me].translation[2];
          if (pass == 0) {
            gap[me] = fmin(gap[me], s->low - below);
            bottom[me] = fmin(bottom[me], s->low);
            top[me] = fmax(top[me], s->high);
            volume[me] += (s->high - s->low) * g.size * g.size;
            over[me] += in_other * g.size * g.size;
            rock[me] += in_rock * g.size * g.size;
          }
          for (int d = 0; d < 16; ++d) {
            const double along = x * cos(d * 0.39269908169872414) + z * sin(d * 0.39269908169872414);
            if (pass == 0)
              far[me][d] = fmax(far[me][d], along);
            else if (s->low - below < gap[me] + 0.5 * coarse || s->low - below < 0.25 * coarse)
              bear[me][d] = fmax(bear[me][d], along);
          }
        }
      }
  totals t = {.blocks = count};
  uint32_t kept = 0;
  double height = v.max[1] - rules->ground;
  for (uint32_t i = 0; i < count; ++i) {
    const scree_block* b = &blocks[resting[i].block];
    const double size = cbrt(b->volume);
    double wide = 0;
    if (!(volume[i] > 0)) continue;
    ++kept;
    for (int d = 0; d < 8; ++d) wide = fmax(wide, far[i][d] + far[i][d + 8]);
    bool unsteady = false;
    for (int d = 0; d < 16; ++d) unsteady = unsteady || bear[i][d] < -0.02 * size;
    const bool higher = resting[i].translation[1] > b->centroid[1] + 0.02 * size, end = top[i] - bottom[i] > 1.5 * wide;
    const bool floats = gap[i] > 0.1 * size, sunk = over[i] > 0.15 * volume[i], in_rock = rock[i] > 0.15 * volume[i];
    t.higher += higher;
    t.on_end += end;
    t.floating += floats;
    t.sunk += sunk;
    t.in_rock += in_rock;
    t.unsteady += unsteady;
    t.high_up += bottom[i] > rules->ground + 0.4 * height;
    t.gap += fmax(gap[i], 0) / size;
    t.overlap += over[i] / volume[i];
    t.rock_overlap += rock[i] / volume[i];
  }
  const double n = kept > 0 ? kept : 1;
  printf(
      "%-14s time %u: fell %5u lie %5u  higher %5.1f %%  on end %5.1f %%  unsteady %5.1f %%  high up %5.1f %%  float %5.1f %% "
      "(mean gap %.3f)  in rock %5.1f %% (%.3f)  in blocks %5.1f %% (%.3f)\n",
      name, time, fallen, count, 100 * t.higher / n, 100 * t.on_end / n, 100 * t.unsteady / n, 100 * t.high_up / n,
      100 * t.floating / n, t.gap / n, 100 * t.in_rock / n, t.rock_overlap / n, 100 * t.sunk / n, t.overlap / n);
  fflush(stdout);
  for (uint32_t c = 0; c < g.count[0] * g.count[1]; ++c) free(g.columns[c].spans);
  free(g.columns);
  free(gap);
  free(bottom);
  free(top);
  free(volume);
  free(over);
  free(rock);
  free(far);
  free(bear);
  scree_rubble_destroy(rubble);
}

int main(int count, char** names) {
  for (int n = 1; n < count; ++n) {
    static scree_shard_recipe recipe;
    scree_error error = {{0}};
    shard_files files;
    char* text;
    size_t size;
    if (file_read(names[n], 1 << 20, &text, &size, &error) != SCREE_OK ||
        scree_shard_recipe_parse(text, size, &recipe, &error) != SCREE_OK ||
        shard_files_read(&recipe, names[n], &files, &error) != SCREE_OK) {
      fprintf(stderr, "%s\n", error.message);
      return 1;
    }
    scree_shard_desc desc = {.recipe = &recipe};
    shard_files_give(&files, &desc);
    shard_weather weather;
    scree_frost_stats stats;
    if (shard_weather_create(&desc, NULL, NULL, &weather, &error) != SCREE_OK ||
        shard_weather_start(&weather, &error) != SCREE_OK) {
      fprintf(stderr, "%s\n", error.message);
      return 1;
    }
    for (uint32_t t = 0; t < shard_times(&recipe); ++t) {
      if (shard_weather_advance(&weather, t, NULL, NULL, &stats, &error) != SCREE_OK) {
        fprintf(stderr, "%s\n", error.message);
        return 1;
      }
      if (t + 2 >= shard_times(&recipe)) look(&weather, &recipe, recipe.name, t);
    }
    shard_weather_destroy(&weather);
    shard_files_free(&files);
    free(text);
  }
  return 0;
}
