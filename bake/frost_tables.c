/* What paths look up: where water can go down to, how rains fall, and room for the weights of where it starts. */
#include <string.h>

#include "frost_internal.h"

static frost_rain make_rain(const scree_rain* rule) {
  const double pi = 3.14159265358979323846;
  frost_rain rain = {.weight = rule->weight};
  double flow[3];
  frost_unit(rule->direction, flow);
  for (int a = 0; a < 3; ++a) rain.axis[a] = -flow[a];
  int least = 0; /* the axis that the rain lies furthest from */
  for (int a = 1; a < 3; ++a)
    if (fabs(flow[a]) < fabs(flow[least])) least = a;
  double side[3];
  for (int a = 0; a < 3; ++a) side[a] = (a == least) - rain.axis[least] * rain.axis[a];
  frost_unit(side, rain.side);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    rain.other[a] = rain.axis[b] * rain.side[c] - rain.axis[c] * rain.side[b];
  }
  const double half =
      repeatable_cos_to_pi(pi / 2 - rule->spread / 2 > 0 ? pi / 2 - rule->spread / 2 : 0); /* the sine of half of it */
  rain.cosine = repeatable_cos_to_pi(rule->spread);
  rain.sine = repeatable_cos_to_pi(fabs(pi / 2 - rule->spread));
  rain.cap = rule->spread > 0 ? 2 * half * half : 0; /* not 1 - cosine, which loses small spreads */
  return rain;
}

/* --- ways down --------------------------------------------------------------------------------------------------------------- */

static double height_of(const scree_link* link, const double gravity[3]) {
  return gravity[0] * link->centroid[0] + gravity[1] * link->centroid[1] + gravity[2] * link->centroid[2];
}

/* f_g, by how far down each lies, so that no rounding lets water go in circles. <= 0 where it cannot go. */
static double pull_of(const scree_link* from, const scree_link* to, const double gravity[3]) {
  const double down = height_of(to, gravity) - height_of(from, gravity);
  if (!(down > 0)) return 0;
  double length2 = 0;
  for (int a = 0; a < 3; ++a) length2 += (to->centroid[a] - from->centroid[a]) * (to->centroid[a] - from->centroid[a]);
  return down / sqrt(length2);
}

static uint32_t count_ways(const scree_shards_view* v, const double gravity[3]) {
  uint32_t count = 0;
  for (uint32_t l = 0; l < v->link_count; ++l)
    for (uint32_t k = v->neighbour_first[l]; k < v->neighbour_first[l + 1]; ++k)
      count += pull_of(&v->links[l], &v->links[v->neighbours[k]], gravity) > 0;
  return count;
}

static void fill_ways(const scree_shards_view* v, frost_tables* t) {
  uint32_t count = 0;
  for (uint32_t l = 0; l < v->link_count; ++l) {
    t->way_first[l] = count;
    for (uint32_t k = v->neighbour_first[l]; k < v->neighbour_first[l + 1]; ++k) {
      const double pull = pull_of(&v->links[l], &v->links[v->neighbours[k]], t->gravity);
      if (pull > 0) t->ways[count++] = (frost_way){.pull = pull, .link = v->neighbours[k]};
    }
  }
  t->way_first[v->link_count] = count;
}

/* --- all of it --------------------------------------------------------------------------------------------------------------- */

static void* take(frost_tables* t, size_t count, size_t size) {
  void* at = t->memory != NULL ? (char*)t->memory + t->size : NULL;
  t->size += (count * size + 63) / 64 * 64;
  return at;
}

/* Parts start at multiples of 64; without memory, says only how much it takes. */
static void lay_out(frost_tables* t, size_t links, size_t ways, size_t rains) {
  t->size = 0;
  t->resistance = take(t, links, sizeof *t->resistance);
  t->way_first = take(t, links + 1, sizeof *t->way_first);
  t->ways = take(t, ways, sizeof *t->ways);
  t->weights = take(t, rains * links, sizeof *t->weights);
  t->trees = take(t, rains * (links + 1), sizeof *t->trees);
}

scree_result frost_tables_create(const scree_shards_view* v, const scree_frost_rules* rules, const scree_allocator* allocator,
                                 frost_tables* out) {
  frost_tables t = {0};
  frost_unit(rules->gravity, t.gravity);
  const uint32_t ways = count_ways(v, t.gravity);
  lay_out(&t, v->link_count, ways, rules->rain_count);
  t.memory = scree_rt_allocate(allocator, t.size, 1);
  if (t.memory == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  lay_out(&t, v->link_count, ways, rules->rain_count);
  for (uint32_t r = 0; r < rules->rain_count; ++r) t.rains[r] = make_rain(&rules->rains[r]);
  for (t.top_bit = 1; t.top_bit <= v->link_count / 2;) t.top_bit *= 2;
  t.solid_absorption = rules->solid_absorption / v->mean_link_area;
  t.air_absorption = rules->air_absorption / v->mean_link_area;
  t.damage = rules->damage * v->mean_link_area;
  frost_resistances(v, &rules->resistance, t.resistance);
  fill_ways(v, &t);
  *out = t;
  return SCREE_OK;
}

void frost_tables_destroy(frost_tables* t, const scree_allocator* allocator) {
  scree_rt_release(allocator, t->memory, t->size, 1);
  *t = (frost_tables){0};
}
