#include "scene_scatter.h"

#include <math.h>
#include <string.h>

bool scree_rt_scene_ground_ends(const scree_support* ground) {
  return !(ground->min[1] <= ground->max[1]) || isfinite(ground->max[1]);
}

void scree_rt_scene_measure_scatter(scene_layer* layer) {
  const scree_scatter* scatter = layer->given.scatter;
  layer->rock_radius = scatter->outer_radius + scatter->sink; /* from the ground under it, too */
  layer->reach = (double)scatter->lattice.centroid_reach + layer->rock_radius;
}

/* --- finding ---------------------------------------------------------------------------------------------------------------- */

typedef struct finding {
  scene_question* q;
  layer_rocks* rocks;
  const scree_scatter* scatter;
  scree_result result;
} finding;

static bool take(void* user, const scatter_found* found) {
  finding* f = user;
  scene_question* q = f->q;
  const uint64_t at = q->count + f->rocks->count;
  if (at >= q->most) {
    f->result = SCREE_ERROR_CAPACITY;
    return false;
  }
  if (at >= scratch_room(q->scratch, SCRATCH_INSTANCES, sizeof *q->instances) ||
      at >= scratch_room(q->scratch, SCRATCH_IDS, sizeof *q->ids)) {
    const size_t wanted = (size_t)(at + at / 2 + 64);
    q->instances = scree_rt_scratch_extend(q->scratch, SCRATCH_INSTANCES, (size_t)at, wanted, sizeof *q->instances);
    q->ids = scree_rt_scratch_extend(q->scratch, SCRATCH_IDS, (size_t)at, wanted, sizeof *q->ids);
    if (q->instances == NULL || q->ids == NULL) {
      f->result = SCREE_ERROR_OUT_OF_MEMORY;
      return false;
    }
  }
  q->ids[at] =
      (scree_id){{found->tile[0], (int32_t)(found->steps[1] >> SCATTER_SIDE_BITS), found->tile[1]}, (uint16_t)found->local, 0};
  for (int a = 0; a < 3; ++a)
    q->instances[at].position[a] = (float)((f->scatter->origin[a] - q->origin[a]) + f->scatter->unit * (double)found->steps[a]);
  q->instances[at].asset = scatter_pack(found->model, found->steps[1]);
  ++f->rocks->count;
  return true;
}

/* The part of the plane where instances are looked for: where they are asked for, and where later layers could meet them. */
static void find_box(const scene_question* q, uint32_t index, scatter_visit* v) {
  const scene_layer* layer = &q->scene->layers[index];
  const layer_rocks* rocks = &q->layers[index];
  const scree_scatter* s = v->scatter;
  for (int i = 0; i < 2; ++i) {
    const int a = 2 * i;
    double low = INFINITY, high = -INFINITY;
    if (rocks->asked && q->box_min != NULL) {
      const double slack = (fabs(q->box_min[a]) + fabs(q->box_max[a]) + fabs(s->origin[a])) * 1e-15;
      low = q->box_min[a] - s->origin[a] - slack;
      high = q->box_max[a] - s->origin[a] + slack;
    } else if (rocks->asked) {
      low = -INFINITY;
      high = INFINITY;
    }
    if (rocks->wanted) {
      const double base = s->origin[a] - q->scene->base[a], slack = (fabs(base) + layer->rock_radius) * 1e-6;
      low = fmin(low, rocks->region_low[a] - layer->rock_radius - base - slack);
      high = fmax(high, rocks->region_high[a] + layer->rock_radius - base + slack);
    }
    v->box_low[i] = low;
    v->box_high[i] = high;
  }
}

scree_result scree_rt_scene_find_scatter(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  layer_rocks* rocks = &q->layers[index];
  scatter_visit visit = {.scatter = layer->given.scatter, .ground = layer->given.support, .layer = layer};
  memcpy(visit.low, rocks->low, sizeof visit.low);
  memcpy(visit.high, rocks->high, sizeof visit.high);
  find_box(q, index, &visit);
  rocks->first = q->count;
  rocks->count = 0;
  q->instances = q->scratch->buffers[SCRATCH_INSTANCES].memory;
  q->ids = q->scratch->buffers[SCRATCH_IDS].memory;
  finding f = {q, rocks, layer->given.scatter, SCREE_OK};
  scree_rt_scatter_visit(&visit, take, &f);
  q->count += rocks->count;
  return f.result;
}

void scree_rt_scene_scatter_box(scene_question* q, uint32_t index) {
  const scene_layer* layer = &q->scene->layers[index];
  const scree_scatter* s = layer->given.scatter;
  layer_rocks* rocks = &q->layers[index];
  for (uint64_t i = rocks->first; i < rocks->first + rocks->count; ++i) {
    double place[3];
    scree_rt_scatter_place(s, &q->ids[i], q->instances[i].asset, place);
    for (int a = 0; a < 3; ++a) {
      const double at = (s->origin[a] - q->scene->base[a]) + place[a];
      if (i == rocks->first || at - layer->rock_radius < rocks->tight_low[a]) rocks->tight_low[a] = at - layer->rock_radius;
      if (i == rocks->first || at + layer->rock_radius > rocks->tight_high[a]) rocks->tight_high[a] = at + layer->rock_radius;
    }
  }
}

/* --- single instances ------------------------------------------------------------------------------------------------------- */

bool scree_rt_scene_scatter_asked(const scene_question* q, const scene_layer* layer, const scree_id* id, uint32_t packed) {
  if (q->box_min == NULL) return true;
  double place[3];
  scree_rt_scatter_place(layer->given.scatter, id, packed, place);
  for (int a = 0; a < 3; ++a) {
    const double at = layer->given.scatter->origin[a] + place[a];
    if (!(at >= q->box_min[a] && at < q->box_max[a])) return false;
  }
  return true;
}

bool scree_rt_scene_scatter_rock(const scene_layer* layer, const scree_id* id, const uint32_t* packed, const double origin[3],
                                 scree_rock* rock) {
  const scree_scatter* s = layer->given.scatter;
  uint32_t known = 0;
  if (s->is_cliff) {
    const cliff_point* point = scree_rt_cliff_point(s, id->cube[0], id->cube[2], id->local);
    if (point == NULL || point->steps[1] >> SCATTER_SIDE_BITS != id->cube[1]) return false;
    known = scatter_pack(point->asset, point->steps[1]);
  } else {
    int64_t steps[2];
    if (!scree_rt_scatter_steps(s, id->cube[0], id->cube[2], id->local, steps)) return false;
    if (rock == NULL) return true;
    known = packed != NULL
                ? *packed
                : scatter_pack(scree_rt_scatter_choose(s, scree_rt_scatter_hash(s, id->cube[0], id->cube[2], id->local), steps),
                               SCATTER_SIDE / 2);
  }
  if (rock == NULL) return true;
  const uint32_t model = scatter_model_of(known);
  double place[3];
  scree_rt_scatter_place(s, id, known, place);
  for (int a = 0; a < 3; ++a) rock->position[a] = (float)((s->origin[a] - origin[a]) + place[a]);
  rock->asset = model;
  rock->id = *id;
  return true;
}

double scree_rt_scene_scatter_ball(const scene_layer* layer, const scree_id* id, uint32_t packed, uint32_t part,
                                   const double from[3], double home[3], double centre[3]) {
  const scree_scatter* s = layer->given.scatter;
  double place[3];
  scree_rt_scatter_place(s, id, packed, place);
  const uint32_t first = s->models[scatter_model_of(packed)].first_part;
  const double radius = scree_rt_scatter_ball(s, first + part, scree_scatter_random(s, id), centre);
  for (int a = 0; a < 3; ++a) {
    home[a] = (s->origin[a] - from[a]) + place[a];
    centre[a] += home[a];
  }
  return radius;
}

convex_hull scree_rt_scene_scatter_hull(const scene_layer* layer, const scree_id* id, uint32_t packed, uint32_t part, float* x,
                                        float* y, float* z) {
  const scree_scatter* s = layer->given.scatter;
  const uint32_t first = s->models[scatter_model_of(packed)].first_part;
  float scale;
  convex_hull hull = {.x = x, .y = y, .z = z};
  hull.count = scree_rt_scatter_hull(s, first + part, scree_scatter_random(s, id), x, y, z, &scale);
  hull.scale = (double)scale;
  return hull;
}
