/* One path of water, from where it starts to where it ends: sections 5.1 and 5.2 of Mateos et al. */
#include "frost_draw.h"

/* The link at which the running sum of weights exceeds `place`. */
static uint32_t find(const frost_tables* t, uint32_t rain, size_t link_count, uint64_t place) {
  const uint64_t* tree = t->trees + rain * (link_count + 1);
  size_t at = 0;
  for (size_t step = t->top_bit; step > 0; step >>= 1)
    if (at + step <= link_count && tree[at + step] <= place) {
      at += step;
      place -= tree[at];
    }
  return (uint32_t)at;
}

/* Which rain: by weight, of those that meet a link. False when none does. */
static bool draw_rain(scree_frost* f, uint32_t* out) {
  const frost_tables* t = &f->tables;
  double sum = 0;
  uint32_t wet = 0;
  for (uint32_t r = 0; r < f->rules.rain_count; ++r) {
    if (t->totals[r] == 0) continue;
    sum += t->rains[r].weight;
    *out = r;
    ++wet;
  }
  if (wet < 2) return wet == 1;
  double left = random_unit(&f->stream) * sum;
  for (uint32_t r = 0; r < f->rules.rain_count; ++r) {
    if (t->totals[r] == 0) continue;
    *out = r;
    left -= t->rains[r].weight;
    if (left < 0) return true;
  }
  return true;
}

/* All exterior links weighed against one direction, after many proposals were refused. False when it meets none. */
static bool weigh_all(scree_frost* f, const double direction[3], uint32_t* out) {
  const scree_shards_view* v = &f->view;
  uint64_t total = 0;
  for (uint32_t l = 0; l < v->link_count; ++l)
    if (f->exterior[l] != 0)
      total += (uint64_t)frost_share(&v->links[l], frost_stands(f, v->links[l].shards[0]), direction, f->weight_scale);
  if (total == 0) return false;
  uint64_t place = frost_draw_below(&f->stream, total);
  for (uint32_t l = 0; l < v->link_count; ++l) {
    if (f->exterior[l] == 0) continue;
    const uint64_t share = (uint64_t)frost_share(&v->links[l], frost_stands(f, v->links[l].shards[0]), direction, f->weight_scale);
    *out = l;
    if (place < share) return true;
    place -= share;
  }
  return true;
}

static bool draw_start(scree_frost* f, uint32_t* out) {
  const scree_shards_view* v = &f->view;
  for (int sky = 0; sky < FROST_SKIES; ++sky) {
    uint32_t rain = 0;
    double direction[3];
    if (!draw_rain(f, &rain)) return false;
    frost_draw_direction(&f->tables.rains[rain], &f->stream, direction);
    const uint64_t* weights = f->tables.weights + (size_t)rain * v->link_count;
    for (int i = 0; i < FROST_PROPOSALS; ++i) {
      const uint32_t at = find(&f->tables, rain, v->link_count, frost_draw_below(&f->stream, f->tables.totals[rain]));
      const scree_link* link = &v->links[at];
      const double share = frost_share(link, frost_stands(f, link->shards[0]), direction, f->weight_scale);
      if (random_unit(&f->stream) * (double)weights[at] < share) {
        *out = at;
        return true;
      }
    }
    if (weigh_all(f, direction, out)) return true;
  }
  return false;
}

/* Where water goes on from a link. False where it goes nowhere. */
static bool draw_way(scree_frost* f, uint32_t* link) {
  const frost_way* ways = f->tables.ways + f->tables.way_first[*link];
  const uint32_t count = f->tables.way_first[*link + 1] - f->tables.way_first[*link];
  double sum = 0;
  for (uint32_t i = 0; i < count; ++i) sum += ways[i].pull * f->passage[ways[i].link];
  if (!(sum > 0)) return false;
  double left = random_unit(&f->stream) * sum;
  for (uint32_t i = 0; i < count; ++i) {
    const double share = ways[i].pull * f->passage[ways[i].link];
    if (!(share > 0)) continue;
    *link = ways[i].link; /* the last one, where rounding leaves some */
    if (left < share) break;
    left -= share;
  }
  return true;
}

/* The harm that water does to a link that lives. */
static void wear(scree_frost* f, uint32_t link, double taken) {
  const double life = f->lives[link] - f->tables.damage * taken / f->view.links[link].area;
  bool forced = false;
  if (life > 0 && life < f->rules.break_life)
    forced = random_unit(&f->stream) < f->rules.break_chance * (1 - life / f->rules.break_life);
  if (life > 0 && !forced) {
    f->lives[link] = life;
    f->passage[link] = 1 - life * f->tables.resistance[link];
    return;
  }
  f->stats.forced += forced;
  frost_break_link(f, link);
}

bool frost_path(scree_frost* f) {
  uint32_t link;
  if (!draw_start(f, &link)) return false;
  const double poured = f->rules.water;
  double water = poured;
  ++f->stats.paths;
  f->stats.poured += poured;
  f->path_length = 0;
  do {
    if (f->path_length < FROST_LAST_PATH) {
      f->path_links[f->path_length] = link;
      f->path_water[f->path_length] = water;
    }
    ++f->path_length;
    const double life = f->lives[link], area = f->view.links[link].area;
    double taken = life > 0 ? area * f->tables.solid_absorption + life * f->tables.resistance[link] * f->rules.resistance_absorption
                            : area * f->tables.air_absorption;
    if (taken > water) taken = water;
    if (life > 0) wear(f, link, taken);
    water -= taken;
    f->stats.absorbed += taken;
    if (water > 0 && f->rules.total_absorption && random_unit(&f->stream) < 1 - water / poured) {
      f->stats.absorbed += water; /* it harms no link: damage is of w_abs */
      water = 0;
    }
  } while (water > 0 && draw_way(f, &link));
  f->stats.links_visited += f->path_length;
  f->stats.drained += water;
  return true;
}
