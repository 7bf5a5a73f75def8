/* One block on its way: out of the rock, down, onto a face, down the slope, and turned until its centre of mass is as low as it can
 * be there, which is what it is to lie still. Everything is asked of the columns under its hull. */
#include <math.h>
#include <string.h>

#include "rubble_internal.h"

enum { DIRECTIONS = RUBBLE_DIRECTIONS, LOOK_AHEAD = 6 };

typedef rubble_fit fit;

/* floor, without a call to it where the processor has no instruction for it. */
static int32_t whole_below(double value) {
  const int32_t whole = (int32_t)value;
  return whole - (value < whole);
}

static double step_length(const rubble_mover* m, int direction) {
  return m->solid->size * (direction % 2 ? sqrt(2.0) : 1);
}

void rubble_rotate(const double q[4], const double p[3], double out[3]) {
  const double t[3] = {2 * (q[1] * p[2] - q[2] * p[1]), 2 * (q[2] * p[0] - q[0] * p[2]), 2 * (q[0] * p[1] - q[1] * p[0])};
  out[0] = p[0] + q[3] * t[0] + q[1] * t[2] - q[2] * t[1];
  out[1] = p[1] + q[3] * t[1] + q[2] * t[0] - q[0] * t[2];
  out[2] = p[2] + q[3] * t[2] + q[0] * t[1] - q[1] * t[0];
}

/* First b, then a; unit again. */
static void turn_by(const double a[4], const double b[4], double out[4]) {
  const double q[4] = {a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1], a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0],
                       a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3],
                       a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2]};
  const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; ++i) out[i] = q[i] / length;
}

/* --- columns under a block ------------------------------------------------------------------------------------------------------
 */

static void widen(rubble_cell* cell, double height) {
  if (height < cell->low) cell->low = height;
  if (height > cell->high) cell->high = height;
}

/* The middles of columns under one triangle. places: its corners, in columns across and lengths upwards. */
static void cover(const double a[3], const double b[3], const double c[3], const int32_t from[2], const int32_t side[2],
                  rubble_cell* cells) {
  const double area = (b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]);
  if (!(area > 1e-9 || area < -1e-9)) return;
  const double inverse = 1 / area;
  int32_t low[2], high[2];
  for (int axis = 0; axis < 2; ++axis) {
    const double u = a[2 * axis], v = b[2 * axis], w = c[2 * axis];
    low[axis] = whole_below((u < v ? (u < w ? u : w) : (v < w ? v : w)) + 0.5 - 1e-9);
    high[axis] = whole_below((u > v ? (u > w ? u : w) : (v > w ? v : w)) - 0.5 + 1e-9);
    if (low[axis] < from[axis]) low[axis] = from[axis];
    if (high[axis] > from[axis] + side[axis] - 1) high[axis] = from[axis] + side[axis] - 1;
  }
  for (int32_t k = low[1]; k <= high[1]; ++k)
    for (int32_t i = low[0]; i <= high[0]; ++i) {
      const double x = i + 0.5, z = k + 0.5;
      const double wa = ((b[0] - x) * (c[2] - z) - (b[2] - z) * (c[0] - x)) * inverse;
      const double wb = ((c[0] - x) * (a[2] - z) - (c[2] - z) * (a[0] - x)) * inverse, wc = 1 - wa - wb;
      if (wa < -1e-9 || wb < -1e-9 || wc < -1e-9) continue;
      const double height = wa * a[1] + wb * b[1] + wc * c[1];
      rubble_cell* cell = &cells[(i - from[0]) + side[0] * (k - from[1])];
      if (height < cell->mid_low) cell->mid_low = height;
      if (height > cell->mid_high) cell->mid_high = height;
    }
}

void rubble_rasterise(const rubble_mover* m, const double turn[4], const double part[2], rubble_raster* out) {
  const rubble_hull* hull = m->hull;
  double places[HULL_POINTS][3], low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY};
  for (uint32_t p = 0; p < hull->point_count; ++p) {
    rubble_rotate(turn, hull->points[p], places[p]);
    for (int axis = 0; axis < 2; ++axis) {
      places[p][2 * axis] = places[p][2 * axis] / m->solid->size + part[axis];
      if (places[p][2 * axis] < low[axis]) low[axis] = places[p][2 * axis];
      if (places[p][2 * axis] > high[axis]) high[axis] = places[p][2 * axis];
    }
  }
  int32_t from[2], side[2];
  for (int axis = 0; axis < 2; ++axis) {
    from[axis] = whole_below(low[axis]);
    side[axis] = whole_below(high[axis]) - from[axis] + 1;
  }
  const uint32_t all = (uint32_t)(side[0] * side[1]);
  for (uint32_t c = 0; c < all; ++c)
    out->cells[c] =
        (rubble_cell){INFINITY, -INFINITY, INFINITY, -INFINITY, {from[0] + (int32_t)c % side[0], from[1] + (int32_t)c / side[0]}};
  for (uint32_t t = 0; t < hull->triangle_count; ++t) {
    const uint8_t* corner = hull->triangles[t];
    cover(places[corner[0]], places[corner[1]], places[corner[2]], from, side, out->cells);
  }
  for (uint32_t c = 0; c < all; ++c) {
    out->cells[c].low = out->cells[c].mid_low;
    out->cells[c].high = out->cells[c].mid_high;
  }
  for (uint32_t p = 0; p < hull->point_count; ++p) {
    const int32_t i = whole_below(places[p][0]) - from[0], k = whole_below(places[p][2]) - from[1];
    widen(&out->cells[i + side[0] * k], places[p][1]);
  }
  out->count = 0;
  for (uint32_t c = 0; c < all; ++c)
    if (out->cells[c].low <= out->cells[c].high) out->cells[out->count++] = out->cells[c];
}

rubble_fit rubble_fits(const rubble_mover* m, const rubble_raster* raster, const int32_t column[2], double height, double enough,
                       double* rest) {
  const dexels* d = m->solid;
  double floor_height = -INFINITY;
  for (uint32_t c = 0; c < raster->count; ++c) {
    const rubble_cell* cell = &raster->cells[c];
    const int32_t i = column[0] + cell->column[0], k = column[1] + cell->column[1];
    if (i < 0 || k < 0 || i >= (int32_t)d->count[0] || k >= (int32_t)d->count[1]) return FIT_OUT;
    const double low = height + cell->low + m->give;
    double high = height + cell->high - m->give;
    if (high < low) high = low;
    double top = -INFINITY;
    for (uint32_t n = d->first[(uint32_t)i + d->count[0] * (uint32_t)k]; n != DEXEL_END; n = d->pool[n].next) {
      if (d->pool[n].low >= high) break;
      if (d->pool[n].high > low) return FIT_BLOCKED;
      top = d->pool[n].high;
    }
    if (top - cell->low > floor_height) floor_height = top - cell->low;
    if (floor_height >= enough) return FIT_BLOCKED;
  }
  *rest = floor_height;
  return FIT_FREE;
}

static fit fits(const rubble_mover* m, const rubble_raster* raster, const int32_t column[2], double height, double* rest) {
  return rubble_fits(m, raster, column, height, INFINITY, rest);
}

/* --- ways -------------------------------------------------------------------------------------------------------------------- */

static void swap_rasters(rubble_mover* m) {
  const rubble_raster swap = m->rasters[0];
  m->rasters[0] = m->rasters[1];
  m->rasters[1] = swap;
}

/* Turns it as given, lifted if it must be. Returns whether there was room. */
static bool try_turn(rubble_mover* m, rubble_pose* pose, const double turn[4]) {
  rubble_rasterise(m, turn, pose->part, &m->rasters[1]);
  for (int lift = 0; lift < 3; ++lift) {
    double rest;
    if (fits(m, &m->rasters[1], pose->column, pose->height + lift * 0.5 * m->hull->radius, &rest) != FIT_FREE) continue;
    if (rest > m->limit) continue;
    memcpy(pose->turn, turn, sizeof pose->turn);
    pose->height = rest;
    swap_rasters(m);
    return true;
  }
  return false;
}

/* The turn that lays it on a face: half way between the face's normal and down, then spun about the vertical. */
static void turn_onto(const hull_face* face, const double spin[4], double out[4]) {
  const double* n = face->normal;
  double down[4] = {n[2], 0, -n[0], 1 - n[1]};
  if (down[3] < 1e-6) {
    down[0] = 1;
    down[2] = down[3] = 0;
  }
  turn_by(spin, down, out);
}

static void any_spin(random_stream* stream, double out[4]) {
  for (;;) {
    const double x = 2 * random_unit(stream) - 1, y = 2 * random_unit(stream) - 1;
    if (x * x + y * y > 1 || x * x + y * y < 1e-3) continue;
    out[0] = out[2] = 0;
    out[1] = x;
    out[3] = y;
    return;
  }
}

/* The largest faces, of which it lies on one rather than on others. */
static uint32_t good_faces(const rubble_hull* hull) {
  uint32_t good = 0;
  while (good < hull->face_count && good < 3 && hull->faces[good].area > 0.5 * hull->faces[0].area) ++good;
  return good;
}

/* Lays it on one of its largest faces, spun about the vertical. */
static void lie_down(rubble_mover* m, rubble_pose* pose) {
  const uint32_t good = good_faces(m->hull);
  if (good == 0) return;
  const uint32_t first = (uint32_t)(random_unit(&m->stream) * good);
  for (uint32_t attempt = 0; attempt < 6; ++attempt) {
    double spin[4], turn[4];
    any_spin(&m->stream, spin);
    turn_onto(&m->hull->faces[(first + attempt / 3) % good], spin, turn);
    if (try_turn(m, pose, turn)) return;
  }
}

/* Goes `steps` columns in a direction, up by at most `climb` at each. Returns whether there is a way; height: there. */
static fit walk(const rubble_mover* m, const rubble_pose* pose, int direction, uint32_t steps, double climb, double* height) {
  int32_t at[2] = {pose->column[0], pose->column[1]};
  double now = pose->height;
  for (uint32_t s = 0; s < steps; ++s) {
    at[0] += rubble_directions[direction][0];
    at[1] += rubble_directions[direction][1];
    double rest;
    fit f = fits(m, &m->rasters[0], at, now, &rest);
    if (f == FIT_BLOCKED && climb > 0) f = fits(m, &m->rasters[0], at, now + climb, &rest);
    if (f != FIT_FREE) return f;
    if (rest > pose->height + climb) return FIT_BLOCKED;
    now = rest;
  }
  *height = now;
  return FIT_FREE;
}

static void go(rubble_pose* pose, int direction, uint32_t steps, double height) {
  pose->column[0] += (int32_t)steps * rubble_directions[direction][0];
  pose->column[1] += (int32_t)steps * rubble_directions[direction][1];
  pose->height = height;
}

/* Down the steepest way while it is steeper than `slope`, and on a little by what it fell: farther for larger blocks. Looks a few
 * columns ahead, over bumps that are small to it. Returns false when it left the grid. */
static bool roll(const rubble_mover* m, rubble_pose* pose, bool* moved) {
  const double size = m->hull->size, most = 1.2 * size, climb = 0.2 * size / m->slope;
  double energy = 0;
  int heading = -1;
  *moved = false;
  const uint32_t far = 4 * (m->solid->count[0] + m->solid->count[1]);
  for (uint32_t n = 0; n < far; ++n) {
    double steepest = m->slope, there = 0;
    int way = -1;
    uint32_t steps = 0;
    for (uint32_t look = 1; look <= LOOK_AHEAD && way < 0; ++look) {
      if (look > 1 && (look - 1) * m->solid->size > 1.5 * size) break;
      for (int k = 0; k < DIRECTIONS; ++k) {
        double height;
        const fit f = walk(m, pose, k, look, look > 1 ? climb : 0, &height);
        if (f == FIT_OUT) return false;
        if (f != FIT_FREE) continue;
        const double slope = (pose->height - height) / (look * step_length(m, k));
        if (slope <= steepest) continue;
        steepest = slope;
        there = height;
        way = k;
        steps = look;
      }
    }
    if (way >= 0) {
      const double drop = pose->height - there, length = steps * step_length(m, way);
      energy += drop > 2 * size ? 0.3 * drop : drop - m->slope * length;
      if (energy > most) energy = most;
    } else {
      if (heading < 0 || !(energy > 0)) return true;
      for (int k = 0; k < 3; ++k) {
        static const int beside[3] = {0, 1, DIRECTIONS - 1};
        const int to = (heading + beside[k]) % DIRECTIONS;
        double height;
        const fit f = walk(m, pose, to, 1, energy < 0.3 * size ? energy : 0.3 * size, &height);
        if (f == FIT_OUT) return false;
        if (f != FIT_FREE || (way >= 0 && height >= there)) continue;
        way = to;
        there = height;
      }
      if (way < 0) return true;
      steps = 1;
      energy -= m->slope * step_length(m, way) + (there - pose->height);
      if (energy < 0) return true;
    }
    heading = way;
    go(pose, way, steps, there);
    *moved = true;
  }
  return true;
}

/* Tries it turned by `angle`, the tangent of half the turn, so that the side towards `direction` goes down, and moved that way by
 * `steps` columns. Keeps it where its centre of mass is lower than `best`. */
static bool try_tip(rubble_mover* m, const rubble_pose* pose, int direction, double angle, int steps, rubble_pose* best) {
  const double part = angle * (direction % 2 ? sqrt(0.5) : 1);
  const double by[4] = {part * rubble_directions[direction][1], 0, -part * rubble_directions[direction][0], 1};
  rubble_pose tried = *pose;
  turn_by(by, pose->turn, tried.turn);
  for (int axis = 0; axis < 2; ++axis) tried.column[axis] += steps * rubble_directions[direction][axis];
  rubble_rasterise(m, tried.turn, tried.part, &m->rasters[1]);
  const double lifted = pose->height + angle * m->hull->radius;
  if (rubble_fits(m, &m->rasters[1], tried.column, lifted, best->height, &tried.height) != FIT_FREE) return false;
  *best = tried;
  return true;
}

/* Turns it about level axes while that brings its centre of mass down, where it must with a step aside: it then lies on three
 * places at least, or against a wall. */
static void tip(rubble_mover* m, rubble_pose* pose) {
  for (double angle = 0.14; angle > 0.01; angle *= 0.5)
    for (int round = 0; round < 12; ++round) {
      rubble_pose best = *pose;
      best.height -= 1e-3 * m->hull->size;
      bool found = false;
      for (int steps = 0; steps < 2 && !found; ++steps)
        for (int k = 0; k < DIRECTIONS; ++k) found |= try_tip(m, pose, k, angle, steps, &best);
      if (!found) break;
      *pose = best;
      rubble_rasterise(m, pose->turn, pose->part, &m->rasters[0]);
    }
}

/* Whether it stands on end. */
static bool stands(const rubble_mover* m, const rubble_pose* pose) {
  /* Of eight level directions, 22.5 degrees apart. */
  static const double level[8][2] = {{1, 0},
                                     {0.9238795325112867, 0.3826834323650898},
                                     {0.7071067811865476, 0.7071067811865476},
                                     {0.3826834323650898, 0.9238795325112867},
                                     {0, 1},
                                     {-0.3826834323650898, 0.9238795325112867},
                                     {-0.7071067811865476, 0.7071067811865476},
                                     {-0.9238795325112867, 0.3826834323650898}};
  double low[9], high[9], widest = 0;
  for (int k = 0; k < 9; ++k) {
    low[k] = INFINITY;
    high[k] = -INFINITY;
  }
  for (uint32_t p = 0; p < m->hull->point_count; ++p) {
    double at[3];
    rubble_rotate(pose->turn, m->hull->points[p], at);
    for (int k = 0; k < 9; ++k) {
      const double along = k < 8 ? level[k][0] * at[0] + level[k][1] * at[2] : at[1];
      if (along < low[k]) low[k] = along;
      if (along > high[k]) high[k] = along;
    }
  }
  for (int k = 0; k < 8; ++k)
    if (high[k] - low[k] > widest) widest = high[k] - low[k];
  return high[8] - low[8] > 1.25 * widest;
}

/* Whether its centre of mass is above what bears it from below: not all of that is on one side. */
static bool balances(const rubble_mover* m, const rubble_pose* pose) {
  const dexels* d = m->solid;
  double most[DIRECTIONS];
  for (int k = 0; k < DIRECTIONS; ++k) most[k] = -INFINITY;
  for (uint32_t c = 0; c < m->rasters[0].count; ++c) {
    const rubble_cell* cell = &m->rasters[0].cells[c];
    const int32_t at[2] = {pose->column[0] + cell->column[0], pose->column[1] + cell->column[1]};
    if (!dexels_hold(d, at, pose->height + cell->low - 0.3 * d->size)) continue;
    const double x = cell->column[0] + 0.5 - pose->part[0], z = cell->column[1] + 0.5 - pose->part[1];
    for (int k = 0; k < DIRECTIONS; ++k) {
      const double along = x * rubble_directions[k][0] + z * rubble_directions[k][1];
      if (along > most[k]) most[k] = along;
    }
  }
  for (int k = 0; k < DIRECTIONS; ++k)
    if (!(most[k] > 0)) return false;
  return true;
}

/* What stands on end or hangs over falls: onto one of its largest faces, beside where it is if there is no room, wherever that is
 * lowest. Returns whether there is such a place, lower than where it is. */
static bool topple(rubble_mover* m, rubble_pose* pose) {
  const rubble_hull* hull = m->hull;
  const uint32_t good = good_faces(hull);
  /* 45 degrees about the vertical. */
  static const double eighth[4] = {0, 0.3826834323650898, 0, 0.9238795325112867};
  double spin[4];
  any_spin(&m->stream, spin);
  rubble_pose best = *pose;
  best.height -= 0.05 * hull->size;
  bool found = false;
  for (uint32_t attempt = 0; attempt < 8 * good; ++attempt) {
    rubble_pose tried = *pose;
    double next[4];
    turn_onto(&hull->faces[attempt / 8], spin, tried.turn);
    turn_by(eighth, spin, next);
    memcpy(spin, next, sizeof spin);
    rubble_rasterise(m, tried.turn, pose->part, &m->rasters[1]);
    for (int k = -1; k < 3 * DIRECTIONS; ++k) {
      for (int axis = 0; axis < 2 && k >= 0; ++axis) {
        const double aside = 0.5 * (1 + k / DIRECTIONS) * hull->radius * (k % 2 ? sqrt(0.5) : 1) / m->solid->size;
        tried.column[axis] = pose->column[axis] + whole_below(aside * rubble_directions[k % DIRECTIONS][axis] + 0.5);
      }
      if (rubble_fits(m, &m->rasters[1], tried.column, pose->height, best.height, &tried.height) != FIT_FREE) continue;
      if (!rubble_clear(m, pose->column, tried.column, pose->height)) continue;
      best = tried;
      found = true;
    }
  }
  if (!found) return false;
  *pose = best;
  rubble_rasterise(m, pose->turn, pose->part, &m->rasters[0]);
  return true;
}

static bool settle_down(rubble_mover* m, rubble_pose* pose) {
  for (int round = 0; round < 4; ++round) {
    bool moved;
    if (!roll(m, pose, &moved)) return false;
    if (round > 0 && !moved) break;
    tip(m, pose);
  }
  return true;
}

bool rubble_move(rubble_mover* m, rubble_pose* pose, const double push[3]) {
  rubble_rasterise(m, pose->turn, pose->part, &m->rasters[0]);
  if (!rubble_leave(m, pose, push)) return false;
  lie_down(m, pose);
  if (!settle_down(m, pose)) return false;
  for (int round = 0; round < 3 && (stands(m, pose) || !balances(m, pose)); ++round) {
    if (!topple(m, pose)) break;
    if (!settle_down(m, pose)) return false;
  }
  return true;
}
