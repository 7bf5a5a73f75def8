/* Which meshes are resident. The coarsest level of every asset always is; finer ones come when runs ask for them and go when room
 * is short and nothing has used them for longest. Users are counted by instances of runs. */
#include <string.h>

#include "stream_internal.h"
#include "support_text.h"

enum { COARSEST_ROCKS = 2048 }; /* in one update, where proxies are shown meanwhile */

static void put_idle(scree_stream* s, uint32_t slot) {
  stream_mesh* mesh = &s->meshes[slot];
  mesh->before = s->idle_last;
  mesh->after = STREAM_NONE;
  if (s->idle_last != STREAM_NONE)
    s->meshes[s->idle_last].after = slot;
  else
    s->idle_first = slot;
  s->idle_last = slot;
  s->idle_bytes += stream_mesh_bytes(mesh);
}

static void take_idle(scree_stream* s, uint32_t slot) {
  stream_mesh* mesh = &s->meshes[slot];
  if (mesh->before != STREAM_NONE)
    s->meshes[mesh->before].after = mesh->after;
  else
    s->idle_first = mesh->after;
  if (mesh->after != STREAM_NONE)
    s->meshes[mesh->after].before = mesh->before;
  else
    s->idle_last = mesh->before;
  mesh->before = mesh->after = STREAM_NONE;
  s->idle_bytes -= stream_mesh_bytes(mesh);
}

static bool can_idle(const stream_mesh* mesh) {
  return mesh->state == MESH_IN && !mesh->coarsest;
}

/* A mesh of a pack can be drawn from now on, or no longer. */
static void count_absent(scree_stream* s, stream_pack* p, uint32_t asset, uint32_t level, bool absent) {
  p->absent[asset >= p->assets][s->classes[p->first_asset + asset]][level] += absent ? 1u : UINT32_MAX;
}

void scree_rt_stream_mesh_use(scree_stream* s, uint32_t slot) {
  stream_mesh* mesh = &s->meshes[slot];
  if (mesh->refs++ == 0 && can_idle(mesh)) take_idle(s, slot);
}

void scree_rt_stream_mesh_leave(scree_stream* s, uint32_t slot) {
  stream_mesh* mesh = &s->meshes[slot];
  if (--mesh->refs == 0 && can_idle(mesh)) put_idle(s, slot);
}

bool scree_rt_stream_mesh_ask(scree_stream* s, uint32_t pack, uint32_t asset, uint32_t level) {
  const stream_mesh* mesh = &s->meshes[stream_mesh_slot(&s->packs[pack], asset, level)];
  if (mesh->state != MESH_OUT || s->desc.decode == NULL) return false;
  uint64_t bytes = stream_mesh_bytes(mesh), cap = s->desc.caps.mesh_bytes;
  if (s->mesh_bytes + s->coming_bytes + bytes > cap + s->idle_bytes) {
    s->short_of_meshes = !s->roomy; /* if it is, meshes of an earlier scene are on their way out */
    return false;
  }
  return scree_rt_stream_decode_start(s, pack, asset, level);
}

/* --- in and out ------------------------------------------------------------------------------------------------------------- */

static void send_out(scree_stream* s, uint32_t pack, uint32_t asset, uint32_t level) {
  uint32_t slot = stream_mesh_slot(&s->packs[pack], asset, level);
  stream_mesh* mesh = &s->meshes[slot];
  scree_event* event = scree_rt_stream_send(s, SCREE_EVENT_MESH_OUT, 0);
  event->mesh.pack = s->packs[pack].pack;
  event->mesh.asset = asset;
  event->mesh.level = level;
  event->mesh.mesh = slot;
  if (can_idle(mesh) && !s->roomy) take_idle(s, slot);
  count_absent(s, &s->packs[pack], asset, level, true);
  mesh->state = MESH_OUT;
  s->mesh_bytes -= stream_mesh_bytes(mesh);
  --s->meshes_in;
  --s->packs[pack].meshes_in;
}

static void send_in(scree_stream* s, uint32_t pack, uint32_t asset, uint32_t level, const scree_vertex* vertices,
                    const uint16_t* indices) {
  uint32_t slot = stream_mesh_slot(&s->packs[pack], asset, level);
  stream_mesh* mesh = &s->meshes[slot];
  scree_event* event = scree_rt_stream_send(s, SCREE_EVENT_MESH_IN, stream_mesh_bytes(mesh));
  event->mesh = (scree_event_mesh){.pack = s->packs[pack].pack,
                                   .asset = asset,
                                   .level = level,
                                   .mesh = slot,
                                   .vertices = vertices,
                                   .indices = indices,
                                   .vertex_count = mesh->vertices,
                                   .index_count = mesh->triangles * 3};
  mesh->state = MESH_IN;
  count_absent(s, &s->packs[pack], asset, level, false);
  s->mesh_bytes += stream_mesh_bytes(mesh);
  ++s->meshes_in;
  ++s->packs[pack].meshes_in;
  if (can_idle(mesh) && mesh->refs == 0 && !s->roomy) put_idle(s, slot);
}

void scree_rt_stream_meshes_recount(scree_stream* s) {
  s->idle_first = s->idle_last = STREAM_NONE;
  s->idle_bytes = 0;
  for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
    const stream_pack* p = &s->packs[i];
    if (!stream_pack_is_used(p)) continue;
    for (uint32_t slot = p->first_mesh; slot < p->first_mesh + p->total * p->levels; ++slot) {
      stream_mesh* mesh = &s->meshes[slot];
      mesh->refs = 0;
      mesh->before = mesh->after = STREAM_NONE;
      if (can_idle(mesh) && !s->roomy) put_idle(s, slot);
    }
  }
  for (uint32_t i = 0; i < s->blocks_used; ++i)
    if (s->blocks[i].shown) scree_rt_stream_levels_recount(s, i);
}

static uint32_t pack_of(const scree_stream* s, uint32_t slot) {
  for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
    const stream_pack* p = &s->packs[i];
    if (p->pack != NULL && slot >= p->first_mesh && slot - p->first_mesh < p->total * p->levels) return i;
  }
  return STREAM_NONE;
}

/* Lets go of idle meshes until `bytes` more fit, with `events` to spare for what comes after. */
static bool make_room(scree_stream* s, uint64_t bytes) {
  while (s->mesh_bytes + bytes > s->desc.caps.mesh_bytes) {
    uint32_t slot = s->idle_first;
    if (slot == STREAM_NONE || !scree_rt_stream_can_send(s, 2, bytes)) return false;
    uint32_t pack = pack_of(s, slot), at = slot - s->packs[pack].first_mesh, levels = s->packs[pack].levels;
    send_out(s, pack, at / levels, at % levels);
  }
  return true;
}

static void say_broken(const scree_stream* s, uint32_t asset, uint32_t level, scree_result result) {
  if (s->desc.log.write == NULL) return;
  scree_error line;
  scree_rt_text_clear(&line);
  scree_rt_text_add(&line, "level ");
  scree_rt_text_add_count(&line, level);
  scree_rt_text_add(&line, " of asset ");
  scree_rt_text_add_count(&line, asset);
  scree_rt_text_add(&line, " cannot be decoded: ");
  scree_rt_text_add(&line, scree_result_string(result));
  s->desc.log.write(s->desc.log.user, SCREE_LOG_WARNING, line.message);
}

/* --- coarsest meshes -------------------------------------------------------------------------------------------------------- */

bool scree_rt_stream_mesh_fits(const scree_pack* pack, uint32_t asset, uint32_t level, const stream_mesh* mesh) {
  scree_lod lod;
  return scree_pack_get_lod(pack, asset, level, &lod) == SCREE_OK && lod.vertices == mesh->vertices &&
         lod.triangles == mesh->triangles;
}

static scree_result read_coarsest(const scree_stream* s, const stream_pack* p, uint32_t asset, scree_vertex* vertices,
                                  uint16_t* indices) {
  const stream_mesh* mesh = &s->meshes[stream_mesh_slot(p, asset, p->levels - 1)];
  if (!scree_rt_stream_mesh_fits(p->pack, asset, p->levels - 1, mesh)) return SCREE_ERROR_CORRUPT;
  return scree_pack_coarse_mesh(p->pack, asset, vertices, mesh->vertices, indices, (size_t)mesh->triangles * 3);
}

/* Vertices are put into the staging buffer from its start, indices from its end, so that neither needs padding. */
static void send_coarsest(scree_stream* s, uint32_t pack, uint32_t kind, uint32_t most) {
  stream_pack* p = &s->packs[pack];
  uint32_t first = kind == 0 ? 0 : p->assets, end = kind == 0 ? p->assets : p->total;
  size_t low = s->staging_low, high = s->staging_high;
  for (uint32_t sent = 0; first + p->coarse_next[kind] < end && sent < most; ++sent) {
    uint32_t asset = first + p->coarse_next[kind];
    stream_mesh* mesh = &s->meshes[stream_mesh_slot(p, asset, p->levels - 1)];
    uint64_t bytes = stream_mesh_bytes(mesh);
    if (bytes > high - low || !scree_rt_stream_can_send(s, 1, bytes) || !make_room(s, bytes)) break;
    if (!scree_rt_stream_can_send(s, 1, bytes)) break; /* the events of others that went out */
    size_t indices_at = high - (size_t)mesh->triangles * 3 * sizeof(uint16_t);
    scree_vertex* vertices = (scree_vertex*)(void*)(s->staging + low);
    uint16_t* indices = (uint16_t*)(void*)(s->staging + indices_at);
    scree_result result = read_coarsest(s, p, asset, vertices, indices);
    ++p->coarse_next[kind];
    if (result != SCREE_OK) {
      mesh->state = MESH_VOID;
      count_absent(s, p, asset, p->levels - 1, false);
      say_broken(s, asset, p->levels - 1, result);
      continue;
    }
    send_in(s, pack, asset, p->levels - 1, vertices, indices);
    low += mesh->vertices * sizeof(scree_vertex);
    high = indices_at;
  }
  s->staging_low = low;
  s->staging_high = high;
}

bool scree_rt_stream_coarsest_are_in(const scree_stream* s, uint32_t layer, uint32_t level) {
  const stream_pack* p = &s->packs[s->layers[layer].pack];
  return level == 0 ? p->coarse_next[0] == p->assets : p->coarse_next[1] == p->total - p->assets;
}

/* Proxies first: they are what a first picture consists of. Rocks then take a few updates, because a mesh takes time to unpack. */
static void send_all_coarsest(scree_stream* s) {
  for (uint32_t kind = 2; kind-- > 0;)
    for (uint32_t i = 0; i < STREAM_PACKS; ++i) {
      const stream_pack* p = &s->packs[i];
      if (p->pack == NULL || p->dead) continue;
      bool apart = kind == 0 && p->total > p->assets && !s->desc.no_far_field;
      send_coarsest(s, i, kind, apart ? COARSEST_ROCKS : UINT32_MAX);
    }
}

/* --- decoded meshes --------------------------------------------------------------------------------------------------------- */

/* Returns false when it has to wait for another update. */
static bool send_decoded(scree_stream* s, stream_decode* d) {
  stream_mesh* mesh = &s->meshes[d->mesh];
  uint64_t bytes = stream_mesh_bytes(mesh);
  if (s->packs[d->pack].dead) {
    mesh->state = MESH_OUT;
  } else if (d->result != SCREE_OK) {
    mesh->state = MESH_FAILED;
    say_broken(s, d->asset, d->level, d->result);
  } else {
    if (!scree_rt_stream_can_send(s, 1, bytes)) return false;
    if (!make_room(s, bytes)) {
      if (s->idle_first != STREAM_NONE || s->roomy) return false;
      mesh->state = MESH_OUT;
      s->short_of_meshes = true;
    } else if (!scree_rt_stream_can_send(s, 1, bytes)) {
      return false;
    } else {
      send_in(s, d->pack, d->asset, d->level, d->vertices, d->indices);
    }
  }
  s->coming_bytes -= bytes;
  --s->decodes_under_way;
  d->sent = true;
  return true;
}

/* Once nothing draws with it any more. */
static void send_dead_out(scree_stream* s, uint32_t pack) {
  stream_pack* p = &s->packs[pack];
  if (p->blocks > 0) return;
  for (uint32_t asset = 0; asset < p->total && p->meshes_in > 0; ++asset)
    for (uint32_t level = 0; level < p->levels; ++level) {
      const stream_mesh* mesh = &s->meshes[stream_mesh_slot(p, asset, level)];
      if (mesh->state != MESH_IN) continue;
      if (!scree_rt_stream_can_send(s, 1, 0)) return;
      send_out(s, pack, asset, level);
    }
}

void scree_rt_stream_meshes_send(scree_stream* s) {
  s->staging_low = 0;
  s->staging_high = s->staging_size / 2 * 2;
  for (uint32_t i = 0; i < STREAM_PACKS; ++i)
    if (s->packs[i].pack != NULL && s->packs[i].dead && s->packs[i].meshes_in > 0) send_dead_out(s, i);
  send_all_coarsest(s);
  for (uint32_t i = 0; i < s->decode_queue.count; ++i) {
    stream_decode* d = &s->decodes[s->decode_queue.order[i]];
    if (d->sent || !atomic_load_explicit(&d->task.done, memory_order_acquire)) continue;
    if (!send_decoded(s, d)) break;
  }
}
