/* Resistance of the material at the middle of each link.
 * Noise is based on: Perlin, Improving Noise, 2002: twelve gradients, quintic fade; its lattice is hashed. */
#include <string.h>

#include "frost_internal.h"

/* --- noise ------------------------------------------------------------------------------------------------------------------- */

static double fade(double t) {
  return t * t * t * (t * (t * 6 - 15) + 10);
}

static double gradient(uint64_t key, const int64_t at[3], const double d[3]) {
  static const int8_t gradients[12][3] = {{1, 1, 0},  {-1, 1, 0},  {1, -1, 0}, {-1, -1, 0}, {1, 0, 1},  {-1, 0, 1},
                                          {1, 0, -1}, {-1, 0, -1}, {0, 1, 1},  {0, -1, 1},  {0, 1, -1}, {0, -1, -1}};
  uint64_t hash = key;
  for (int a = 0; a < 3; ++a) hash = hash_combine(hash, (uint64_t)at[a]);
  const int8_t* g = gradients[(hash >> 32) * 12 >> 32];
  return g[0] * d[0] + g[1] * d[1] + g[2] * d[2];
}

/* About -1..1. */
static double noise(uint64_t key, const double place[3]) {
  int64_t base[3];
  double in[3], blend[3], sum = 0;
  for (int a = 0; a < 3; ++a) {
    base[a] = (int64_t)floor(place[a]);
    in[a] = place[a] - floor(place[a]);
    blend[a] = fade(in[a]);
  }
  for (int corner = 0; corner < 8; ++corner) {
    int64_t at[3];
    double d[3], weight = 1;
    for (int a = 0; a < 3; ++a) {
      const int far = corner >> a & 1;
      at[a] = base[a] + far;
      d[a] = in[a] - far;
      weight *= far != 0 ? blend[a] : 1 - blend[a];
    }
    sum += weight * gradient(key, at, d);
  }
  return sum;
}

static double octaves(const scree_resistance* rule, const double place[3]) {
  const uint32_t count = rule->octaves != 0 ? rule->octaves : 1;
  double sum = 0, amplitude = rule->amplitude, frequency = 1 / rule->period;
  for (uint32_t i = 0; i < count; ++i) {
    const double at[3] = {place[0] * frequency, place[1] * frequency, place[2] * frequency};
    sum += amplitude * noise(hash_combine(hash_mix(rule->random_seed), i), at);
    amplitude /= 2;
    frequency *= 2;
  }
  return sum;
}

/* --- layers and images ------------------------------------------------------------------------------------------------------- */

static double layered(const scree_resistance* rule, const double up[3], const double place[3]) {
  const double height = place[0] * up[0] + place[1] * up[1] + place[2] * up[2];
  uint32_t above = 0; /* points that are not above the place */
  while (above < rule->layer_count && rule->layers[2 * (size_t)above] <= height) ++above;
  if (above == 0) return rule->layers[1];
  const double* low = rule->layers + 2 * (size_t)(above - 1);
  if (above == rule->layer_count) return low[1];
  return low[1] + (low[3] - low[1]) * ((height - low[0]) / (low[2] - low[0]));
}

/* Trilinear between the middles of voxels, the outermost ones held beyond. */
static double image(const scree_resistance* rule, const double min[3], const double max[3], const double place[3]) {
  size_t at[3][2];
  double blend[3], sum = 0;
  for (int a = 0; a < 3; ++a) {
    const double last = rule->size[a] - 1;
    double x = max[a] > min[a] ? (place[a] - min[a]) / (max[a] - min[a]) * rule->size[a] - 0.5 : 0;
    x = x > 0 ? x : 0;
    x = x < last ? x : last;
    at[a][0] = (size_t)x;
    at[a][1] = at[a][0] + (at[a][0] + 1 < rule->size[a]);
    blend[a] = x - floor(x);
  }
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int a = 0; a < 3; ++a) weight *= (corner >> a & 1) != 0 ? blend[a] : 1 - blend[a];
    const size_t slice = at[2][corner >> 2] * rule->size[1] + at[1][corner >> 1 & 1];
    sum += weight * rule->images[slice * rule->size[0] + at[0][corner & 1]];
  }
  return sum / 255;
}

/* --- all of them ------------------------------------------------------------------------------------------------------------- */

static void call_function(const scree_shards_view* view, const scree_resistance* rule, double* out) {
  double places[3 * 64];
  for (uint32_t from = 0; from < view->link_count; from += 64) {
    const uint32_t count = view->link_count - from < 64 ? view->link_count - from : 64;
    for (uint32_t i = 0; i < count; ++i) memcpy(places + 3 * (size_t)i, view->links[from + i].centroid, 3 * sizeof(double));
    for (uint32_t i = 0; i < count; ++i) out[from + i] = 0;
    rule->function(rule->user, places, out + from, count);
  }
}

void frost_resistances(const scree_shards_view* view, const scree_resistance* rule, double* out) {
  const bool noisy = (rule->kind == SCREE_RESISTANCE_NOISE || rule->kind == SCREE_RESISTANCE_LAYERS) && rule->amplitude > 0;
  double up[3] = {0, 1, 0};
  if (rule->kind == SCREE_RESISTANCE_LAYERS) frost_unit(rule->up, up); /* stays where none is given */
  bool box = false;
  for (int a = 0; a < 3; ++a) box = box || rule->min[a] != 0 || rule->max[a] != 0;
  if (rule->kind == SCREE_RESISTANCE_FUNCTION) call_function(view, rule, out);
  for (uint32_t l = 0; l < view->link_count; ++l) {
    const double* place = view->links[l].centroid;
    double value = rule->value;
    if (rule->kind == SCREE_RESISTANCE_FUNCTION) value = out[l];
    if (rule->kind == SCREE_RESISTANCE_LAYERS) value = layered(rule, up, place);
    if (rule->kind == SCREE_RESISTANCE_IMAGES) value = image(rule, box ? rule->min : view->min, box ? rule->max : view->max, place);
    if (noisy) value += octaves(rule, place);
    if (!(value > 0)) value = 0; /* what is not a number, too */
    out[l] = value < 1 - 0x1p-20 ? value : 1 - 0x1p-20;
  }
}
