/* Based on: Peytavie et al. 2009, section 5. Where we differ: a contact exists only where the pair owns it, that is, where no third
 * seed is nearer; keeping all pairs of neighbouring cells gives 26 contacts a rock and shapes like clay. */
#include "contacts.h"

#include <math.h>

#include "blocks.h"
#include "lattice.h"

void neighbourhood_gather(const seed_set* set, uint32_t code, int32_t x, int32_t y, int32_t z, neighbourhood* out) {
  out->unit = set->unit;
  for (int32_t i = 0; i < 27; ++i)
    out->seeds[i] = seeds_of_cell(set, code, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1, &out->counts[i]);
}

static double quadratic_form(const float m[6], const double d[3]) {
  const double mx = (double)m[0] * d[0] + (double)m[3] * d[1] + (double)m[4] * d[2];
  const double my = (double)m[1] * d[1] + (double)m[5] * d[2];
  return mx * d[0] + my * d[1] + (double)m[2] * d[2] * d[2];
}

/* Product of the axes' weights at p cells from a cell's centre; infinite outside the support. */
static double cell_weight(const double p[3]) {
  double weight = 1, slope;
  for (int axis = 0; axis < 3; ++axis) {
    const double t = fabs(p[axis]);
    if (t >= 1) return INFINITY;
    if (t > 0.5) weight *= support_weight(t, &slope);
  }
  return weight;
}

/* Distance from a seed at p, in units from the centre of the cell that `cell` is relative to. Infinite outside the support. */
static double seed_distance(const rock_seed* seed, const int32_t cell[3], int32_t unit, const double p[3]) {
  double from_cell[3], d[3];
  for (int axis = 0; axis < 3; ++axis) {
    from_cell[axis] = (p[axis] - (double)cell[axis] * unit) / unit;
    d[axis] = from_cell[axis] - (double)seed->position[axis] / unit;
  }
  const double weight = cell_weight(from_cell);
  return weight < INFINITY ? quadratic_form(seed->metric, d) * weight : INFINITY;
}

/* The point between two seeds where their distances are equal, rounded to units. All cells are relative to the lower one. On the
 * way from one seed to the other both quadratic forms are the same form of the whole way, times the share of it squared. */
static void bisect(const rock_seed* lower, const rock_seed* upper, const int32_t offset[3], int32_t unit, int32_t out[3]) {
  double from[3], along[3], p[3], q[3];
  for (int axis = 0; axis < 3; ++axis) {
    from[axis] = (double)lower->position[axis] / unit;
    along[axis] = (double)(upper->position[axis] + offset[axis] * unit - lower->position[axis]) / unit;
  }
  const double lower_form = quadratic_form(lower->metric, along), upper_form = quadratic_form(upper->metric, along);
  double low = 0, high = 1;
  for (int step = 0; step < 16; ++step) { /* 2 cells / 2^16 is below one unit */
    const double middle = (low + high) * 0.5, rest = 1 - middle;
    for (int axis = 0; axis < 3; ++axis) {
      p[axis] = from[axis] + along[axis] * middle;
      q[axis] = p[axis] - offset[axis];
    }
    if (middle * middle * lower_form * cell_weight(p) < rest * rest * upper_form * cell_weight(q))
      low = middle;
    else
      high = middle;
  }
  for (int axis = 0; axis < 3; ++axis) out[axis] = (int32_t)floor((from[axis] + along[axis] * high) * unit + 0.5);
}

/* Is any seed but the pair nearer to the point than the lower one? `lower` and `upper` are places in the 27 cells, `point` is
 * relative to the lower cell. Every seed whose support holds the point lies in the 27 cells, because the point lies in both rocks'
 * supports. */
static bool third_is_nearer(const neighbourhood* around, uint32_t lower, uint32_t lower_seed, uint32_t upper, uint32_t upper_seed,
                            const int32_t offset[3], const int32_t point[3]) {
  const double p[3] = {point[0], point[1], point[2]};
  static const int32_t zero[3] = {0, 0, 0};
  const double own = fmax(seed_distance(&around->seeds[lower][lower_seed], zero, around->unit, p),
                          seed_distance(&around->seeds[upper][upper_seed], offset, around->unit, p));
  const int32_t base[3] = {(int32_t)(lower % 3), (int32_t)(lower / 3 % 3), (int32_t)(lower / 9)};
  int32_t first[3];
  for (int axis = 0; axis < 3; ++axis) first[axis] = (int32_t)floor((double)point[axis] / around->unit);
  for (int32_t corner = 0; corner < 8; ++corner) {
    const int32_t cell[3] = {first[0] + (corner & 1), first[1] + (corner >> 1 & 1), first[2] + (corner >> 2)};
    int32_t at[3];
    bool inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      at[axis] = base[axis] + cell[axis];
      inside = inside && at[axis] >= 0 && at[axis] <= 2;
    }
    if (!inside) continue; /* a point on the very border of both supports */
    const uint32_t place = (uint32_t)(at[0] + 3 * at[1] + 9 * at[2]);
    for (uint32_t s = 0; s < around->counts[place]; ++s) {
      if ((place == lower && s == lower_seed) || (place == upper && s == upper_seed)) continue;
      if (seed_distance(&around->seeds[place][s], cell, around->unit, p) < own) return true;
    }
  }
  return false;
}

uint32_t contacts_find(const neighbourhood* around, uint32_t seed, double discard, rock_contact* contacts) {
  const rock_seed* own = &around->seeds[13][seed];
  uint32_t count = 0;
  for (uint32_t place = 0; place < 27; ++place) {
    for (uint32_t s = 0; s < around->counts[place]; ++s) {
      if (place == 13 && s == seed) continue;
      const rock_seed* other = &around->seeds[place][s];
      const bool own_is_lower = place > 13 || (place == 13 && seed < s);
      const uint32_t lower = own_is_lower ? 13 : place, upper = own_is_lower ? place : 13;
      const uint32_t lower_seed = own_is_lower ? seed : s, upper_seed = own_is_lower ? s : seed;
      const int32_t offset[3] = {(int32_t)(upper % 3) - (int32_t)(lower % 3), (int32_t)(upper / 3 % 3) - (int32_t)(lower / 3 % 3),
                                 (int32_t)(upper / 9) - (int32_t)(lower / 9)};
      if (discard > 0) {
        const uint64_t pair = hash_combine(own_is_lower ? own->key : other->key, own_is_lower ? other->key : own->key);
        if ((double)(pair >> 11) * 0x1p-53 < discard) continue;
      }
      int32_t point[3];
      bisect(&around->seeds[lower][lower_seed], &around->seeds[upper][upper_seed], offset, around->unit, point);
      if (third_is_nearer(around, lower, lower_seed, upper, upper_seed, offset, point)) continue;
      if (count == MAX_CONTACTS) return count;
      rock_contact* contact = &contacts[count++];
      for (int axis = 0; axis < 3; ++axis) {
        contact->cell[axis] = (int8_t)((axis == 0 ? place % 3 : axis == 1 ? place / 3 % 3 : place / 9) - 1);
        contact->position[axis] = point[axis] + (own_is_lower ? 0 : contact->cell[axis] * around->unit);
      }
      contact->seed = (uint8_t)s;
    }
  }
  return count;
}
