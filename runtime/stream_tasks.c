/* Builds and decodes: work that is done in the background. Each has what it asks, its own scratch and its answer in one place, so
 * tasks share nothing but what nobody changes: the scene, the edits, the classes of assets, the packs.
 *
 * A task is submitted in one update and taken in at a later one. In deterministic mode that is the next one, in the order of
 * submission; without tasks of the host the work is done at submission and taken in at the same point, so the events are the same.
 */
#include <string.h>

#include "scratch.h"
#include "stream_internal.h"

/* --- queues ----------------------------------------------------------------------------------------------------------------- */

static void queue_init(stream_queue* queue, uint32_t* words, uint32_t places) {
  queue->order = words;
  queue->free = words + places;
  queue->count = 0;
  queue->free_count = places;
  for (uint32_t i = 0; i < places; ++i) queue->free[i] = places - 1 - i;
}

static bool queue_take(stream_queue* queue, uint32_t* place) {
  if (queue->free_count == 0) return false;
  *place = queue->free[--queue->free_count];
  queue->order[queue->count++] = *place;
  return true;
}

/* --- running ---------------------------------------------------------------------------------------------------------------- */

/* After `done` is set the stream may be gone. */
static void run_task(void* context) {
  stream_task* task = context;
  task->work(task);
  atomic_store_explicit(&task->done, true, memory_order_release);
}

static void start_task(scree_stream* s, stream_task* task, void (*work)(stream_task* task)) {
  task->stream = s;
  task->work = work;
  atomic_store_explicit(&task->done, false, memory_order_relaxed);
  if (s->desc.tasks.submit != NULL)
    s->desc.tasks.submit(s->desc.tasks.user, run_task, task);
  else
    run_task(task);
}

static bool is_done(const stream_task* task) {
  return atomic_load_explicit(&task->done, memory_order_acquire);
}

static void wait_for(const scree_stream* s, const stream_task* task) {
  while (!is_done(task))
    if (s->desc.tasks.help != NULL) s->desc.tasks.help(s->desc.tasks.user);
}

void scree_rt_stream_tasks_wait(scree_stream* s) {
  for (uint32_t i = 0; i < s->build_queue.count; ++i) wait_for(s, &s->builds[s->build_queue.order[i]].task);
  for (uint32_t i = 0; i < s->decode_queue.count; ++i) wait_for(s, &s->decodes[s->decode_queue.order[i]].task);
}

/* --- builds ----------------------------------------------------------------------------------------------------------------- */

/* Room for `count` rocks, even where places are kept for them: a denser block may find none. */
static bool reserve_build(stream_build* b, uint64_t count) {
  if (count <= b->capacity) return true;
  const scree_allocator* allocator = &b->task.stream->allocator;
  if (count > 1u << 30) return false;
  uint32_t capacity = (uint32_t)(count + count / 4 + 63) / 64 * 64;
  scree_rt_release(allocator, b->own_instances, b->capacity, sizeof *b->own_instances);
  scree_rt_release(allocator, b->own_ids, b->capacity, sizeof *b->own_ids);
  scree_rt_release(allocator, b->keys, (size_t)2 * b->capacity, sizeof *b->keys);
  b->own_instances = scree_rt_allocate(allocator, capacity, sizeof *b->own_instances);
  b->own_ids = scree_rt_allocate(allocator, capacity, sizeof *b->own_ids);
  b->keys = scree_rt_allocate(allocator, (size_t)2 * capacity, sizeof *b->keys);
  if (b->own_instances == NULL || b->own_ids == NULL || b->keys == NULL) {
    scree_rt_release(allocator, b->own_instances, capacity, sizeof *b->own_instances);
    scree_rt_release(allocator, b->own_ids, capacity, sizeof *b->own_ids);
    scree_rt_release(allocator, b->keys, (size_t)2 * capacity, sizeof *b->keys);
    b->own_instances = NULL;
    b->own_ids = NULL;
    b->keys = NULL;
    b->capacity = 0;
    return false;
  }
  b->capacity = capacity;
  return true;
}

/* Sorts keys by their upper halves; equal ones keep their order. Returns the sorted ones: keys or other. */
static uint64_t* sort_keys(uint64_t* keys, uint64_t* other, uint32_t count) {
  for (uint32_t shift = 32; shift < 64; shift += 8) {
    uint32_t first[257] = {0};
    for (uint32_t i = 0; i < count; ++i) ++first[(keys[i] >> shift & 255) + 1];
    if (count > 0 && first[(keys[0] >> shift & 255) + 1] == count) continue;
    for (uint32_t i = 0; i < 256; ++i) first[i + 1] += first[i];
    for (uint32_t i = 0; i < count; ++i) other[first[keys[i] >> shift & 255]++] = keys[i];
    uint64_t* swapped = keys;
    keys = other;
    other = swapped;
  }
  return keys;
}

/* Orders what the scene found by class and asset, and makes instances of it. */
static void arrange(stream_build* b, const scree_rock* rocks, uint32_t count) {
  const scree_stream* s = b->task.stream;
  const stream_pack* pack = &s->packs[s->layers[b->layer].pack];
  const uint8_t* classes = s->classes + pack->first_asset;
  memset(b->class_first, 0, sizeof b->class_first);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < count; ++i) {
    if (rocks[i].asset >= pack->total) continue;
    uint8_t class = classes[rocks[i].asset];
    b->keys[kept++] = (uint64_t)((uint32_t) class << 28 | rocks[i].asset) << 32 | i;
    ++b->class_first[class + 1];
  }
  for (uint32_t c = 0; c < STREAM_CLASSES; ++c) b->class_first[c + 1] += b->class_first[c];
  const uint64_t* sorted = sort_keys(b->keys, b->keys + b->capacity, kept);
  for (uint32_t i = 0; i < kept; ++i) {
    const scree_rock* rock = &rocks[(uint32_t)sorted[i]];
    for (int a = 0; a < 3; ++a) {
      b->instances[i].position[a] = rock->position[a];
      if (i == 0 || rock->position[a] < b->min[a]) b->min[a] = rock->position[a];
      if (i == 0 || rock->position[a] > b->max[a]) b->max[a] = rock->position[a];
    }
    b->instances[i].asset = rock->asset;
    b->instances[i].block = b->label;
    b->instances[i].random = scree_scene_random(s->scene, &rock->id);
    b->ids[i] = rock->id;
  }
  b->count = kept;
  memset(b->triangles, 0, sizeof b->triangles);
  for (uint32_t class = 0; class < STREAM_CLASSES; ++class)
    for (uint32_t i = b->class_first[class]; i < b->class_first[class + 1]; ++i)
      for (uint32_t level = 0; level < pack->levels; ++level)
        b->triangles[class][level] += s->meshes[stream_mesh_slot(pack, b->instances[i].asset, level)].triangles;
}

/* Grows the box of positions by what meshes reach beyond them. */
static void grow_box(stream_build* b) {
  const scree_stream* s = b->task.stream;
  const stream_layer* layer = &s->layers[b->layer];
  const stream_pack* pack = &s->packs[layer->pack];
  for (int a = 0; a < 3; ++a) {
    if (layer->radius > 0) {
      b->min[a] -= layer->radius;
      b->max[a] += layer->radius;
      continue;
    }
    float low = pack->low[a], high = pack->high[a], scale = layer->cell;
    if (b->level > 0) {
      scale *= (float)(1u << (b->level - 1));
      low -= 0.5f;
      high += (float)layer->field->cells_per_cube - 0.5f;
    }
    b->min[a] += low * scale * 1.0001f;
    b->max[a] += high * scale * 1.0001f;
  }
}

static void run_build(stream_task* task) {
  stream_build* b = (stream_build*)(void*)task;
  const scree_stream* s = task->stream;
  const scree_rock* rocks = NULL;
  uint64_t count = 0;
  b->count = 0;
  b->placed = false;
  if (b->level == 0)
    b->result =
        scree_rt_scene_block(s->scene, s->desc.edits, b->layer, b->low, b->high, b->origin, true, b->scratch, &rocks, &count);
  else
    b->result = scree_rt_scene_far(s->scene, b->layer, b->level - 1, b->low, b->high, b->origin, b->scratch, &rocks, &count);
  if (b->result != SCREE_OK || count == 0) return;
  if (!reserve_build(b, count)) {
    b->result = SCREE_ERROR_OUT_OF_MEMORY;
    return;
  }
  b->placed = count <= b->place;
  b->instances = b->placed ? s->instances + b->first : b->own_instances;
  b->ids = b->placed ? s->ids + b->first : b->own_ids;
  arrange(b, rocks, (uint32_t)count);
  grow_box(b);
}

bool scree_rt_stream_build_start(scree_stream* s, uint32_t number) {
  uint32_t place;
  if (!queue_take(&s->build_queue, &place)) return false;
  stream_build* b = &s->builds[place];
  stream_node* node = &s->nodes[number];
  b->node = number;
  b->generation = node->generation;
  b->touch = s->touch;
  b->layer = node->layer;
  b->level = node->level;
  int64_t width = node->level == 0 ? STREAM_BLOCK_CUBES : 2 * STREAM_BLOCK_CUBES; /* in cubes of its own far level */
  for (int a = 0; a < 3; ++a) {
    b->low[a] = (int32_t)(node->at[a] * width);
    b->high[a] = (int32_t)(node->at[a] * width + width);
  }
  stream_node_low(&s->layers[node->layer], node->level, node->at, b->origin);
  node->building = true;
  scree_rt_stream_keep_place(s, b);
  start_task(s, &b->task, run_build);
  return true;
}

/* --- decodes ---------------------------------------------------------------------------------------------------------------- */

static void run_decode(stream_task* task) {
  stream_decode* d = (stream_decode*)(void*)task;
  const scree_stream* s = task->stream;
  const stream_mesh* mesh = &s->meshes[d->mesh];
  d->result = s->desc.decode(s->packs[d->pack].pack, d->asset, d->level, d->vertices, mesh->vertices, d->indices,
                             (size_t)mesh->triangles * 3);
  if (d->result == SCREE_OK && !scree_rt_stream_mesh_fits(s->packs[d->pack].pack, d->asset, d->level, mesh))
    d->result = SCREE_ERROR_CORRUPT;
}

bool scree_rt_stream_decode_start(scree_stream* s, uint32_t pack, uint32_t asset, uint32_t level) {
  uint32_t place;
  if (s->decodes_under_way == s->desc.caps.decodes || !queue_take(&s->decode_queue, &place)) return false;
  ++s->decodes_under_way;
  stream_decode* d = &s->decodes[place];
  d->pack = pack;
  d->asset = asset;
  d->level = level;
  d->mesh = stream_mesh_slot(&s->packs[pack], asset, level);
  d->sent = false;
  d->vertices = s->decode_vertices + place * s->decode_vertex_room;
  d->indices = s->decode_indices + place * s->decode_index_room;
  s->meshes[d->mesh].state = MESH_COMING;
  s->coming_bytes += stream_mesh_bytes(&s->meshes[d->mesh]);
  start_task(s, &d->task, run_decode);
  return true;
}

/* --- taking in -------------------------------------------------------------------------------------------------------------- */

static void collect_builds(scree_stream* s) {
  stream_queue* queue = &s->build_queue;
  uint32_t left = 0;
  for (uint32_t i = 0; i < queue->count; ++i) {
    uint32_t place = queue->order[i];
    if (!is_done(&s->builds[place].task)) {
      queue->order[left++] = place;
      continue;
    }
    scree_rt_stream_take_build(s, &s->builds[place]);
    queue->free[queue->free_count++] = place;
  }
  queue->count = left;
}

/* Gives back the buffers that the events of the last update pointed at. */
static void recycle_decodes(scree_stream* s) {
  stream_queue* queue = &s->decode_queue;
  uint32_t left = 0;
  for (uint32_t i = 0; i < queue->count; ++i) {
    uint32_t place = queue->order[i];
    if (is_done(&s->decodes[place].task) && s->decodes[place].sent)
      queue->free[queue->free_count++] = place;
    else
      queue->order[left++] = place;
  }
  queue->count = left;
}

void scree_rt_stream_tasks_collect(scree_stream* s) {
  if (s->desc.deterministic) scree_rt_stream_tasks_wait(s);
  recycle_decodes(s);
  collect_builds(s);
}

size_t scree_rt_stream_scratch_size(void) {
  return sizeof(scree_scratch);
}

scree_result scree_rt_stream_tasks_init(scree_stream* s) {
  uint32_t builds = s->desc.caps.builds, decodes = 2 * s->desc.caps.decodes;
  memset(s->builds, 0, builds * sizeof *s->builds);
  memset(s->decodes, 0, decodes * sizeof *s->decodes);
  queue_init(&s->build_queue, s->queue_words, builds);
  queue_init(&s->decode_queue, s->queue_words + 2 * builds, decodes);
  for (uint32_t i = 0; i < s->desc.caps.builds; ++i) {
    scree_result result = scree_scratch_create(&s->allocator, &s->builds[i].scratch);
    if (result != SCREE_OK) return result;
  }
  return SCREE_OK;
}

void scree_rt_stream_tasks_destroy(scree_stream* s) {
  scree_rt_stream_tasks_wait(s);
  for (uint32_t i = 0; i < s->desc.caps.builds; ++i) {
    stream_build* b = &s->builds[i];
    scree_scratch_destroy(b->scratch);
    scree_rt_release(&s->allocator, b->own_instances, b->capacity, sizeof *b->own_instances);
    scree_rt_release(&s->allocator, b->own_ids, b->capacity, sizeof *b->own_ids);
    scree_rt_release(&s->allocator, b->keys, (size_t)2 * b->capacity, sizeof *b->keys);
  }
}
