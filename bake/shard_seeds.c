/* Patterns of seeds. All are laid in the space of the pattern (shard_space.h), where cells are not stretched, from the lower corner
 * of the solid's box there; what lies too far from the solid to have a part of it in its cell is left out, which changes no cell
 * within the solid. */
#include <string.h>

#include "random.h"
#include "recipe_text.h"
#include "seed_lay.h"
#include "solid_internal.h"

#define MOST_PLACES 5e7 /* of a lattice in the solid's box, most of them out of reach */

static const double half_sqrt3 = 0.86602540378443864676, one_by_sqrt3 = 0.57735026918962576451;

/* --- what the patterns share ------------------------------------------------------------------------------------------------ */

static scree_result no_memory(scree_error* error) {
  recipe_say(error, "seeds: out of memory");
  return SCREE_ERROR_OUT_OF_MEMORY;
}

static scree_result too_many(scree_error* error) {
  recipe_say(error, "seeds: more than 1000000: spacing is too small or count too large");
  return SCREE_ERROR_RANGE;
}

scree_result seed_add(seed_job* job, const double p[3]) {
  seed_list* list = &job->seeds;
  if (list->count == MOST_SEEDS) return too_many(job->error);
  if (list->count == list->capacity) {
    const uint32_t capacity = list->capacity < 256 ? 256 : 2 * list->capacity;
    double* points = scree_rt_allocate(&job->allocator, (size_t)3 * capacity, sizeof *points);
    if (points == NULL) return no_memory(job->error);
    if (list->count > 0) memcpy(points, list->points, (size_t)3 * list->count * sizeof *points);
    scree_rt_release(&job->allocator, list->points, (size_t)3 * list->capacity, sizeof *points);
    list->points = points;
    list->capacity = capacity;
  }
  memcpy(list->points + (size_t)3 * list->count++, p, 3 * sizeof *p);
  return SCREE_OK;
}

scree_result seed_job_mask(seed_job* job, double step, double most, seed_reach reach, const void* user, seed_mask* out) {
  const scree_result result = seed_mask_create(&(seed_mask_desc){.positions = job->positions,
                                                                 .indices = job->indices,
                                                                 .inside = job->inside.first != NULL ? &job->inside : NULL,
                                                                 .vertex_count = job->vertex_count,
                                                                 .triangle_count = job->triangle_count,
                                                                 .step = step,
                                                                 .most = most,
                                                                 .reach = reach,
                                                                 .user = user},
                                               &job->allocator, out);
  return result == SCREE_OK ? result : no_memory(job->error);
}

static double largest_side(const seed_job* job) {
  double side = 0;
  for (int a = 0; a < 3; ++a) side = fmax(side, job->max[a] - job->min[a]);
  return side;
}

/* Places of a lattice that the mask reaches along an axis. */
typedef struct lattice_range {
  int32_t first, last;
} lattice_range;

/* False where there are more than fit. */
static bool range_of(const seed_mask* mask, int axis, double origin, double spacing, lattice_range* out) {
  const double first = floor((mask->min[axis] - origin) / spacing) - 1;
  const double last = ceil((mask->min[axis] + mask->size[axis] * mask->step - origin) / spacing) + 1;
  if (!(first > -1e9 && last < 1e9)) return false;
  out->first = (int32_t)first, out->last = (int32_t)last;
  return true;
}

static double places(const lattice_range r) {
  return (double)r.last - r.first + 1;
}

/* -1..1 times `most`. */
static double moved(random_stream* stream, double most) {
  return (2 * random_unit(stream) - 1) * most;
}

static scree_result add_within(seed_job* job, const seed_mask* mask, const double p[3]) {
  return seed_mask_has(mask, p) ? seed_add(job, p) : SCREE_OK;
}

/* --- random ----------------------------------------------------------------------------------------------------------------- */

/* Boxes that hold a part of the solid are drawn, all alike, then a place within: what lies outside is drawn again. */
scree_result seeds_random(seed_job* job, uint32_t count, uint64_t random_seed) {
  seed_mask mask;
  const double side = largest_side(job);
  scree_result result = seed_job_mask(job, fmax(side / 64, 1e-12), 0, NULL, NULL, &mask);
  if (result != SCREE_OK) return result;
  const size_t boxes = (size_t)mask.size[0] * mask.size[1] * mask.size[2];
  size_t marked = 0;
  for (size_t i = 0; i < boxes; ++i) marked += mask.marked[i];
  uint32_t* list = scree_rt_allocate(&job->allocator, marked, sizeof *list);
  if (list == NULL) {
    seed_mask_free(&mask, &job->allocator);
    return no_memory(job->error);
  }
  marked = 0;
  for (size_t i = 0; i < boxes; ++i)
    if (mask.marked[i]) list[marked++] = (uint32_t)i;
  random_stream stream = {hash_combine(random_seed, 0x5eed)};
  uint32_t found = 0;
  /* Of a long thin solid the boxes that are drawn hold little: places beside its own box are passed over at once, and many. */
  uint64_t tries = 0, misses = 0;
  const uint64_t most_tries = (uint64_t)count * 1000 + 1000000, most_misses = 4 * most_tries;
  while (result == SCREE_OK && found < count && tries < most_tries && misses < most_misses) {
    uint32_t box = list[(size_t)(random_unit(&stream) * (double)marked)];
    double p[3];
    for (int a = 0; a < 3; ++a) {
      p[a] = mask.min[a] + (box % mask.size[a] + random_unit(&stream)) * mask.step;
      box /= mask.size[a];
    }
    if (p[0] < job->min[0] || p[0] > job->max[0] || p[1] < job->min[1] || p[1] > job->max[1] || p[2] < job->min[2] ||
        p[2] > job->max[2]) {
      ++misses;
      continue;
    }
    ++tries;
    if (!solid_is_inside(&job->inside, p)) continue;
    result = seed_add(job, p);
    ++found;
  }
  if (result == SCREE_OK && found < count) {
    recipe_say(job->error, "seeds: the solid is too thin to find %u places within it", count);
    result = SCREE_ERROR_INVALID_ARGUMENT;
  }
  scree_rt_release(&job->allocator, list, marked, sizeof *list);
  seed_mask_free(&mask, &job->allocator);
  return result;
}

/* --- grid ------------------------------------------------------------------------------------------------------------------- */

static scree_result lay_grid(seed_job* job) {
  const scree_seed_pattern* p = job->pattern;
  const double s = p->count > 0 ? repeatable_cube_root(job->volume / p->count) : p->spacing;
  const double reach = s * half_sqrt3 * (1 + p->jitter); /* no point is farther from its nearest seed */
  seed_mask mask;
  scree_result result = seed_job_mask(job, reach / 3, reach, NULL, NULL, &mask);
  if (result != SCREE_OK) return result;
  lattice_range r[3];
  bool fits = true;
  for (int a = 0; a < 3; ++a) fits = fits && range_of(&mask, a, job->min[a], s, &r[a]);
  if (!fits || places(r[0]) * places(r[1]) * places(r[2]) > MOST_PLACES) {
    seed_mask_free(&mask, &job->allocator);
    return too_many(job->error);
  }
  for (int32_t z = r[2].first; result == SCREE_OK && z <= r[2].last; ++z)
    for (int32_t y = r[1].first; result == SCREE_OK && y <= r[1].last; ++y)
      for (int32_t x = r[0].first; result == SCREE_OK && x <= r[0].last; ++x) {
        const int32_t at[3] = {x, y, z};
        random_stream stream = {hash_corner(p->random_seed, x, y, z)};
        double q[3];
        for (int a = 0; a < 3; ++a) q[a] = job->min[a] + (at[a] + 0.5) * s + moved(&stream, p->jitter * s / 2);
        result = add_within(job, &mask, q);
      }
  seed_mask_free(&mask, &job->allocator);
  return result;
}

/* --- columns ---------------------------------------------------------------------------------------------------------------- */

/* Half the area of the surface seen along y: the area of the shadow of what has no overhangs. */
static double shadow_area(const seed_job* job) {
  double sum = 0;
  for (size_t t = 0; t < job->triangle_count; ++t) {
    const uint32_t* v = job->indices + 3 * t;
    const double *a = job->positions + (size_t)3 * v[0], *b = job->positions + (size_t)3 * v[1],
                 *c = job->positions + (size_t)3 * v[2];
    sum += fabs((b[0] - a[0]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[0] - a[0]));
  }
  return sum / 4;
}

/* One column: a seed at the middle height, or one between two joints each. */
static scree_result lay_column(seed_job* job, const seed_mask* mask, const double at[3], random_stream* stream) {
  const double length = job->pattern->length;
  double q[3] = {at[0], at[1], at[2]};
  if (!(length > 0)) return add_within(job, mask, q);
  const double phase = random_unit(stream);
  const uint64_t key = random_bits(stream);
  lattice_range r;
  if (!range_of(mask, 1, at[1], length, &r)) return too_many(job->error);
  scree_result result = SCREE_OK;
  for (int32_t k = r.first; result == SCREE_OK && k <= r.last; ++k) {
    random_stream joint = {hash_corner(key, k, 0, 0)};
    q[1] = at[1] + (k + phase + moved(&joint, 0.2)) * length;
    result = add_within(job, mask, q);
  }
  return result;
}

static scree_result lay_columns(seed_job* job) {
  const scree_seed_pattern* p = job->pattern;
  double s = p->spacing;
  if (p->count > 0) s = sqrt((p->length > 0 ? job->volume / p->length : shadow_area(job)) / (p->count * half_sqrt3));
  const double across = s * (one_by_sqrt3 + p->jitter * 0.70710678118654752), along = 0.7 * p->length;
  const double reach = sqrt(across * across + along * along), middle = (job->min[1] + job->max[1]) / 2;
  if (!(s > 0)) {
    recipe_say(job->error, "seeds: the solid has no width across its columns");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (!(p->length > 0)) { /* columns have no ends: what counts is the shadow along them */
    solid_inside_free(&job->inside, &job->allocator);
    for (size_t v = 0; v < job->vertex_count; ++v) job->positions[3 * v + 1] = middle;
  }
  seed_mask mask;
  scree_result result = seed_job_mask(job, reach / 3, reach, NULL, NULL, &mask);
  if (result != SCREE_OK) return result;
  const double row = s * half_sqrt3;
  lattice_range x, z, y = {0, 0};
  if (!range_of(&mask, 0, job->min[0], s, &x) || !range_of(&mask, 2, job->min[2], row, &z) ||
      (p->length > 0 && !range_of(&mask, 1, job->min[1], p->length, &y)) || places(x) * places(y) * places(z) > MOST_PLACES) {
    seed_mask_free(&mask, &job->allocator);
    return too_many(job->error);
  }
  for (int32_t k = z.first; result == SCREE_OK && k <= z.last; ++k)
    for (int32_t i = x.first; result == SCREE_OK && i <= x.last; ++i) {
      random_stream stream = {hash_corner(p->random_seed, i, 0, k)};
      const double dx = moved(&stream, p->jitter * s / 2), dz = moved(&stream, p->jitter * s / 2);
      const double at[3] = {job->min[0] + (i + ((k & 1) != 0 ? 0.5 : 0)) * s + dx, p->length > 0 ? job->min[1] : middle,
                            job->min[2] + k * row + dz};
      result = lay_column(job, &mask, at, &stream);
    }
  seed_mask_free(&mask, &job->allocator);
  return result;
}

/* --- slabs ------------------------------------------------------------------------------------------------------------------ */

/* The joint between two layers lies midway between their seeds. So a seed as far below a joint as the next is above it gives every
 * layer its thickness exactly: the height of one seed decides those of all others. Where that would push a seed out of a thin
 * layer, the thick one before it gets two seeds, and with them a joint of its own. */
typedef struct bed {
  double low, thickness;
  double from, to; /* where its (upper) seed may lie above `low` */
  double seeds[2]; /* heights above `low` */
  bool split;      /* two seeds: the upper one is free of the lower one */
} bed;

enum { MOST_BEDS = 4000000 };
#define BED_MARGIN 0.1 /* of the thinner of two layers: nearer to the joint between them no seed lies */

static double thickness_of(const scree_seed_pattern* p, double spacing, int64_t layer) {
  if (p->layer_count == 0) return spacing;
  const int64_t n = p->layer_count, k = layer % n;
  return p->layers[k < 0 ? k + n : k];
}

static double margin(const bed* a, const bed* b) {
  return BED_MARGIN * fmin(a->thickness, b->thickness);
}

static void place_beds(bed* beds, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    bed* b = &beds[i];
    const double low = i > 0 ? margin(b, b - 1) : BED_MARGIN * b->thickness;
    const double high = b->thickness - (i + 1 < count ? margin(b, b + 1) : BED_MARGIN * b->thickness);
    b->split = false;
    b->from = low, b->to = high;
    if (i == 0) continue;
    const double from = fmax(low, b[-1].thickness - b[-1].to), to = fmin(high, b[-1].thickness - b[-1].from);
    if (from <= to)
      b->from = from, b->to = to;
    else
      b[-1].split = true; /* this one is too thin to mirror what is left of the one below */
  }
  /* From above: a chain that ends is free to take the middle of what is left, the others mirror it. */
  for (uint32_t i = count; i-- > 0;) {
    bed* b = &beds[i];
    const double middle = (b->from + b->to) / 2;
    b->seeds[0] = b->seeds[1] = i + 1 == count ? middle : b->thickness - b[1].seeds[0];
    if (b->split) b->seeds[0] = fmax(b->from, fmin(middle, b->seeds[1] - BED_MARGIN * b->thickness));
  }
}

/* The beds from below `bottom` to above `top`, placed; one of them begins at the solid's lower end. Heights are summed from there
 * both ways, so that layers lie where they were asked for. */
static scree_result make_beds(seed_job* job, double spacing, double bottom, double top, bed** out, uint32_t* out_count) {
  const scree_seed_pattern* p = job->pattern;
  uint32_t below = 0, above = 0;
  for (double at = job->min[1]; at > bottom && below < MOST_BEDS; ++below) at -= thickness_of(p, spacing, -(int64_t)below - 1);
  for (double at = job->min[1]; (at < top || above == 0) && above < MOST_BEDS; ++above) at += thickness_of(p, spacing, above);
  const uint32_t count = below + above;
  if (count >= MOST_BEDS) return too_many(job->error);
  bed* beds = scree_rt_allocate(&job->allocator, count, sizeof *beds);
  if (beds == NULL) return no_memory(job->error);
  double height = job->min[1];
  for (uint32_t i = below; i < count; ++i) {
    beds[i].low = height;
    beds[i].thickness = thickness_of(p, spacing, (int64_t)i - below);
    height += beds[i].thickness;
  }
  height = job->min[1];
  for (uint32_t i = below; i-- > 0;) {
    beds[i].thickness = thickness_of(p, spacing, (int64_t)i - below);
    beds[i].low = height -= beds[i].thickness;
  }
  place_beds(beds, count);
  *out = beds;
  *out_count = count;
  return SCREE_OK;
}

/* Between seeds above each other, on average: not that of the layers where some have two seeds. */
static scree_result mean_height(seed_job* job, double* out) {
  bed* beds;
  uint32_t count, seeds = 0;
  const scree_result result = make_beds(job, 0, job->min[1], job->max[1], &beds, &count);
  if (result != SCREE_OK) return result;
  *out = 0;
  for (uint32_t i = 0; i < count; ++i) {
    *out += beds[i].thickness;
    seeds += beds[i].split ? 2 : 1;
  }
  *out /= seeds;
  scree_rt_release(&job->allocator, beds, count, sizeof *beds);
  return result;
}

static scree_result lay_slabs(seed_job* job) {
  const scree_seed_pattern* p = job->pattern;
  double s = p->spacing, most = 0;
  if (p->count > 0 && p->layer_count == 0) s = repeatable_cube_root(job->volume / p->count);
  if (p->count > 0 && p->layer_count > 0) {
    double mean;
    const scree_result result = mean_height(job, &mean);
    if (result != SCREE_OK) return result;
    s = sqrt(job->volume / (p->count * mean));
  }
  for (uint32_t i = 0; i < p->layer_count; ++i) most = fmax(most, p->layers[i]);
  if (p->layer_count == 0) most = s;
  const double across = s * 0.70710678118654752 * (1 + p->jitter), reach = sqrt(across * across + most * most);
  seed_mask mask;
  scree_result result = seed_job_mask(job, fmin(reach, fmin(s, most) * 2) / 3, reach, NULL, NULL, &mask);
  if (result != SCREE_OK) return result;
  bed* beds = NULL;
  uint32_t count = 0;
  result = make_beds(job, s, mask.min[1], mask.min[1] + mask.size[1] * mask.step, &beds, &count);
  lattice_range x = {0}, z = {0};
  if (result == SCREE_OK && (!range_of(&mask, 0, job->min[0], s, &x) || !range_of(&mask, 2, job->min[2], s, &z) ||
                             places(x) * places(z) * count > MOST_PLACES)) {
    scree_rt_release(&job->allocator, beds, count, sizeof *beds);
    result = too_many(job->error);
  }
  if (result != SCREE_OK) {
    seed_mask_free(&mask, &job->allocator);
    return result;
  }
  for (int32_t k = z.first; result == SCREE_OK && k <= z.last; ++k)
    for (int32_t i = x.first; result == SCREE_OK && i <= x.last; ++i) {
      /* The same place in all layers, or else layers would not be flat. */
      random_stream stream = {hash_corner(p->random_seed, i, 0, k)};
      double q[3];
      q[0] = job->min[0] + (i + 0.5) * s + moved(&stream, p->jitter * s / 2);
      q[2] = job->min[2] + (k + 0.5) * s + moved(&stream, p->jitter * s / 2);
      for (uint32_t j = 0; result == SCREE_OK && j < count; ++j)
        for (int part = 0; result == SCREE_OK && part < (beds[j].split ? 2 : 1); ++part) {
          q[1] = beds[j].low + beds[j].seeds[part];
          result = add_within(job, &mask, q);
        }
    }
  scree_rt_release(&job->allocator, beds, count, sizeof *beds);
  seed_mask_free(&mask, &job->allocator);
  return result;
}

/* --- what may be wrong ------------------------------------------------------------------------------------------------------ */

static scree_result refuse(scree_error* error, const char* what, double value, const char* expected) {
  recipe_say(error, "seeds: %s must be %s, not %g", what, expected, value);
  return SCREE_ERROR_RANGE;
}

static bool is_length(double x) {
  return x >= 1e-9 && x <= SOLID_LIMIT;
}

static scree_result check_pattern(const scree_seed_pattern* p, scree_error* error) {
  if (p->kind < SCREE_SEEDS_RANDOM || p->kind > SCREE_SEEDS_POINTS) {
    recipe_say(error, "seeds: no such kind of pattern, %d", (int)p->kind);
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (p->kind == SCREE_SEEDS_POINTS) {
    if (p->points == NULL || p->point_count == 0) {
      recipe_say(error, "seeds: no points");
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    if (p->point_count > MOST_SEEDS) return too_many(error);
    for (size_t i = 0; i < (size_t)3 * p->point_count; ++i)
      if (!(fabs(p->points[i]) <= SOLID_LIMIT)) return refuse(error, "points", p->points[i], "numbers from -1e6 to 1e6");
    return SCREE_OK;
  }
  if (p->count > MOST_SEEDS) return refuse(error, "count", p->count, "at most 1000000");
  if (p->kind == SCREE_SEEDS_RANDOM) {
    if (p->count > 0) return SCREE_OK;
    recipe_say(error, "seeds: count must be at least 1");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  const bool graded_count = p->kind == SCREE_SEEDS_POISSON && p->spacing_end != 0; /* the ratio is needed */
  if ((p->count == 0 || graded_count) && !is_length(p->spacing)) return refuse(error, "spacing", p->spacing, "1e-9 to 1e6");
  if (p->kind == SCREE_SEEDS_POISSON) {
    if (p->spacing_end != 0 && !is_length(p->spacing_end)) return refuse(error, "spacing_end", p->spacing_end, "0 or 1e-9 to 1e6");
    if (p->spacing_end != 0 && !(p->spacing_end <= 100 * p->spacing && p->spacing <= 100 * p->spacing_end))
      return refuse(error, "spacing_end", p->spacing_end, "within 1/100 and 100 times spacing");
    const double* g = p->grade;
    const double length2 = g[0] * g[0] + g[1] * g[1] + g[2] * g[2];
    if (!(length2 == 0 || (length2 > 1e-24 && length2 < 1e24))) return refuse(error, "grade", length2, "a direction");
    return SCREE_OK;
  }
  if (!(p->jitter >= 0 && p->jitter <= 1)) return refuse(error, "jitter", p->jitter, "0..1");
  if (p->kind == SCREE_SEEDS_COLUMNS && !(p->length == 0 || is_length(p->length)))
    return refuse(error, "length", p->length, "0 or 1e-9 to 1e6");
  if (p->kind == SCREE_SEEDS_SLABS) {
    if (p->layer_count > 0 && p->layers == NULL) {
      recipe_say(error, "seeds: no layers");
      return SCREE_ERROR_INVALID_ARGUMENT;
    }
    for (uint32_t i = 0; i < p->layer_count; ++i)
      if (!is_length(p->layers[i])) return refuse(error, "layers", p->layers[i], "1e-9 to 1e6");
  }
  return SCREE_OK;
}

/* --- Poisson discs ---------------------------------------------------------------------------------------------------------- */

#define DISCS_PER_VOLUME 0.72 /* so many discs of radius 1 a cubic unit has, when no more fit */
enum { RADIUS_SAMPLES = 4096 };

/* By what the radii must be multiplied, so that there are `count` discs in the solid. */
static scree_result fit_radius(seed_job* job, seed_radius* r) {
  double mean = 1 / (r->radii[0] * r->radii[0] * r->radii[0]); /* of 1 / radius^3 */
  if (r->radii[0] != r->radii[1]) {
    const scree_result result = seeds_random(job, RADIUS_SAMPLES, 0);
    if (result != SCREE_OK) return result;
    mean = 0;
    for (size_t i = 0; i < job->seeds.count; ++i) {
      const double at = seed_radius_at(r, job->seeds.points + 3 * i);
      mean += 1 / (at * at * at) / RADIUS_SAMPLES;
    }
    job->seeds.count = 0;
  }
  const double scale = repeatable_cube_root(DISCS_PER_VOLUME * job->volume * mean / job->pattern->count);
  for (int i = 0; i < 2; ++i) r->radii[i] *= scale;
  return SCREE_OK;
}

static scree_result lay_poisson(seed_job* job, const shard_space* space) {
  const scree_seed_pattern* p = job->pattern;
  const double *g = p->grade, length = sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const double up[3] = {0, 1, 0}, *along = length > 0 ? g : up;
  const double end = p->spacing_end > 0 ? p->spacing_end : p->spacing;
  seed_radius r = {.radii = {p->spacing, end}};
  if (p->count > 0 && p->spacing_end == 0) r.radii[0] = r.radii[1] = 1;
  /* Heights along the grade are measured in the solid's space: a plane there is a plane in the pattern's. */
  double size = 0;
  for (int i = 0; i < 3; ++i) {
    r.grade[i] = 0;
    for (int a = 0; a < 3; ++a) r.grade[i] += space->axis[i][a] * along[a] * space->stretch[i];
    size += r.grade[i] * r.grade[i];
  }
  for (int i = 0; i < 3; ++i) r.grade[i] /= sqrt(size);
  for (size_t v = 0; v < job->vertex_count; ++v) {
    const double* q = job->positions + 3 * v;
    const double height = r.grade[0] * q[0] + r.grade[1] * q[1] + r.grade[2] * q[2];
    if (v == 0 || height < r.ends[0]) r.ends[0] = height;
    if (v == 0 || height > r.ends[1]) r.ends[1] = height;
  }
  if (p->count > 0) {
    const scree_result result = fit_radius(job, &r);
    if (result != SCREE_OK) return result;
  }
  const double least = fmin(r.radii[0], r.radii[1]), most = fmax(r.radii[0], r.radii[1]);
  /* More than that would not fit even where the radius is largest. */
  if (job->volume / (most * most * most) * 0.5 > MOST_SEEDS || !(least > 0)) return too_many(job->error);
  return seeds_poisson(job, &r, p->random_seed);
}

/* --- all patterns ----------------------------------------------------------------------------------------------------------- */

static scree_result lay(seed_job* job, const shard_space* space) {
  const scree_seed_pattern* p = job->pattern;
  switch (p->kind) {
    case SCREE_SEEDS_RANDOM: return seeds_random(job, p->count, p->random_seed);
    case SCREE_SEEDS_GRID: return lay_grid(job);
    case SCREE_SEEDS_COLUMNS: return lay_columns(job);
    case SCREE_SEEDS_SLABS: return lay_slabs(job);
    default: return lay_poisson(job, space);
  }
}

static scree_result create(seed_job* job, const shard_space* space, const scree_solid* solid) {
  const size_t numbers = (size_t)3 * solid->vertex_count;
  job->positions = scree_rt_allocate(&job->allocator, numbers, sizeof *job->positions);
  if (job->positions == NULL) return no_memory(job->error);
  for (size_t v = 0; v < solid->vertex_count; ++v) shard_space_into(space, solid->positions + 3 * v, job->positions + 3 * v);
  const scree_solid turned = {.positions = job->positions,
                              .indices = solid->indices,
                              .vertex_count = solid->vertex_count,
                              .triangle_count = solid->triangle_count};
  job->indices = solid->indices;
  job->vertex_count = solid->vertex_count, job->triangle_count = solid->triangle_count;
  solid_bounds(&turned, job->min, job->max);
  job->volume = solid_volume6(&turned) / 6;
  scree_result result = SCREE_OK;
  if (!(job->volume > 0)) {
    recipe_say(job->error, "seeds: the solid encloses no volume or is inside out");
    result = SCREE_ERROR_INVALID_ARGUMENT;
  }
  if (result == SCREE_OK) {
    result = solid_inside_create(job->positions, job->indices, job->triangle_count, &job->allocator, &job->inside);
    if (result != SCREE_OK) result = no_memory(job->error);
  }
  if (result == SCREE_OK) result = lay(job, space);
  solid_inside_free(&job->inside, &job->allocator);
  scree_rt_release(&job->allocator, job->positions, numbers, sizeof *job->positions);
  return result;
}

scree_result scree_seeds_create(const scree_seed_pattern* pattern, const scree_solid* solid, const scree_allocator* allocator,
                                double** out, uint32_t* count, scree_error* error) {
  if (out != NULL) *out = NULL;
  if (count != NULL) *count = 0;
  if (pattern == NULL || out == NULL || count == NULL) {
    recipe_say(error, "seeds: no pattern");
    return SCREE_ERROR_INVALID_ARGUMENT;
  }
  shard_space space;
  scree_result result = check_pattern(pattern, error);
  if (result != SCREE_OK) return result;
  if (!shard_space_make(pattern->up, pattern->stretch, &space)) {
    recipe_say(error, "seeds: up must be a direction, stretch 0.01..100");
    return SCREE_ERROR_RANGE;
  }
  const bool given = pattern->kind == SCREE_SEEDS_POINTS;
  if (!given) result = solid_check_numbers(solid, error);
  if (result != SCREE_OK) return result;

  /* What is uniform stays so however it is turned and stretched. */
  if (pattern->kind == SCREE_SEEDS_RANDOM) shard_space_make(NULL, NULL, &space);
  seed_job job = {.pattern = pattern, .allocator = scree_rt_allocator_or_default(allocator), .error = error};
  if (given)
    for (uint32_t i = 0; i < pattern->point_count && result == SCREE_OK; ++i)
      result = seed_add(&job, pattern->points + (size_t)3 * i);
  else
    result = create(&job, &space, solid);
  seed_list* seeds = &job.seeds;
  if (result == SCREE_OK && seeds->count == 0) {
    recipe_say(error, "seeds: none come near the solid");
    result = SCREE_ERROR_INVALID_ARGUMENT;
  }
  double* exact = NULL;
  if (result == SCREE_OK) {
    exact = scree_rt_allocate(&job.allocator, (size_t)3 * seeds->count, sizeof *exact);
    if (exact == NULL) result = no_memory(error);
  }
  if (exact != NULL) {
    for (size_t i = 0; i < seeds->count; ++i)
      if (given)
        memcpy(exact + 3 * i, seeds->points + 3 * i, 3 * sizeof *exact);
      else
        shard_space_out_of(&space, seeds->points + 3 * i, exact + 3 * i);
    *out = exact;
    *count = seeds->count;
  }
  scree_rt_release(&job.allocator, seeds->points, (size_t)3 * seeds->capacity, sizeof *seeds->points);
  return result;
}

void scree_seeds_free(const scree_allocator* allocator, double* seeds, uint32_t count) {
  const scree_allocator memory = scree_rt_allocator_or_default(allocator);
  scree_rt_release(&memory, seeds, (size_t)3 * count, sizeof *seeds);
}
