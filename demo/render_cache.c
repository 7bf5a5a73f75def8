#include "render_cache.h"

#include <stdlib.h>
#include <string.h>

/* Meshes are decoded side by side into one block of this size, then copied to the GPU. */
#define BATCH_BYTES ((size_t)24 << 20)
#define BYTES_MOST ((uint64_t)1536 << 20)

void render_cache_create(render_cache* cache, uint32_t instance_buffer, const scree_jobs* jobs) {
  memset(cache, 0, sizeof *cache);
  cache->instance_buffer = instance_buffer;
  cache->jobs = *jobs;
  cache->bytes_most = BYTES_MOST;
}

void render_cache_destroy(render_cache* cache) {
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) render_cache_remove(cache, s);
  free(cache->wants);
  memset(cache, 0, sizeof *cache);
}

static size_t row_count(const render_source* source) {
  return (size_t)source->asset_count * source->lod_count;
}

uint32_t render_cache_add(render_cache* cache, const render_source* source) {
  if (source->asset_count == 0 || source->lod_count == 0 || source->lod_count > RENDER_LODS) return RENDER_NOTHING;
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) {
    render_cached_source* slot = &cache->sources[s];
    if (slot->used) continue;
    memset(slot, 0, sizeof *slot);
    slot->source = *source;
    slot->assets = malloc(source->asset_count * sizeof *slot->assets);
    slot->rows = malloc(row_count(source) * sizeof *slot->rows);
    if (slot->assets == NULL || slot->rows == NULL) {
      free(slot->assets);
      free(slot->rows);
      return RENDER_NOTHING;
    }
    memcpy(slot->assets, source->assets, source->asset_count * sizeof *slot->assets);
    slot->source.assets = slot->assets;
    memset(slot->rows, 0xff, row_count(source) * sizeof *slot->rows);
    render_meshes_create(&slot->meshes, cache->instance_buffer);
    slot->used = true;
    return s;
  }
  return RENDER_NOTHING;
}

void render_cache_remove(render_cache* cache, uint32_t source) {
  render_cached_source* slot = &cache->sources[source];
  if (!slot->used) return;
  free(slot->assets);
  free(slot->rows);
  render_meshes_destroy(&slot->meshes);
  memset(slot, 0, sizeof *slot);
  uint32_t kept = 0;
  for (uint32_t i = 0; i < cache->want_count; ++i)
    if (cache->wants[i].source != source) cache->wants[kept++] = cache->wants[i];
  cache->want_count = kept;
}

static void want(render_cache* cache, uint32_t source, uint32_t asset, uint32_t lod) {
  if (cache->want_count == cache->want_capacity) {
    uint32_t capacity = cache->want_capacity < 1024 ? 1024 : cache->want_capacity * 2;
    render_want* wants = realloc(cache->wants, capacity * sizeof *wants);
    if (wants == NULL) return; /* asked for again with the next picture */
    cache->wants = wants;
    cache->want_capacity = capacity;
  }
  cache->wants[cache->want_count++] = (render_want){source, asset, lod};
  render_cached_source* slot = &cache->sources[source];
  slot->rows[(size_t)asset * slot->source.lod_count + lod] = RENDER_MESH_WANTED;
}

uint32_t render_cache_find(render_cache* cache, uint32_t source, uint32_t asset, uint32_t lod, uint32_t* found_lod) {
  render_cached_source* slot = &cache->sources[source];
  const uint32_t lods = slot->source.lod_count;
  const uint32_t* rows = slot->rows + (size_t)asset * lods;
  if (rows[lod] == RENDER_MESH_ABSENT) want(cache, source, asset, lod);
  for (uint32_t l = lod; l < lods; ++l)
    if (rows[l] < RENDER_MESH_BROKEN) {
      *found_lod = l;
      return rows[l];
    }
  for (uint32_t l = lod; l-- > 0;)
    if (rows[l] < RENDER_MESH_BROKEN) {
      *found_lod = l;
      return rows[l];
    }
  *found_lod = lod;
  return RENDER_NOTHING;
}

typedef struct batch_item {
  render_want want;
  scree_vertex* vertices;
  uint16_t* indices;
  uint32_t vertex_count, index_count;
  bool good;
} batch_item;

typedef struct batch {
  const render_cache* cache;
  batch_item* items;
} batch;

static void decode_item(void* context, uint32_t index, uint32_t worker) {
  (void)worker;
  const batch* b = context;
  batch_item* item = &b->items[index];
  const render_source* source = &b->cache->sources[item->want.source].source;
  item->good = item->vertex_count > 0 && item->index_count > 0 && item->vertex_count <= 65536 &&
               source->decode(source->user, item->want.asset, item->want.lod, item->vertices, item->indices);
}

static size_t round_up(size_t bytes) {
  return (bytes + 63) / 64 * 64;
}

static void set_row(render_cache* cache, const render_want* w, uint32_t row) {
  render_cached_source* slot = &cache->sources[w->source];
  slot->rows[(size_t)w->asset * slot->source.lod_count + w->lod] = row;
}

void render_cache_trim(render_cache* cache) {
  if (render_cache_bytes(cache) <= cache->bytes_most) return;
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) {
    render_cached_source* slot = &cache->sources[s];
    if (!slot->used) continue;
    render_meshes_clear(&slot->meshes);
    for (size_t i = 0; i < row_count(&slot->source); ++i)
      if (slot->rows[i] < RENDER_MESH_BROKEN) slot->rows[i] = RENDER_MESH_ABSENT;
  }
}

/* Coarse levels first: they are quick to decode and stand in for the fine ones. */
static int by_level(const void* a, const void* b) {
  const render_want *x = a, *y = b;
  if (x->lod != y->lod) return x->lod > y->lod ? -1 : 1;
  if (x->source != y->source) return x->source < y->source ? -1 : 1;
  return x->asset < y->asset ? -1 : x->asset > y->asset;
}

uint32_t render_cache_decode(render_cache* cache, uint32_t budget) {
  cache->decoded = 0;
  if (cache->want_count == 0) return 0;
  qsort(cache->wants, cache->want_count, sizeof *cache->wants, by_level);
  uint32_t most = budget == 0 || budget > cache->want_count ? cache->want_count : budget;
  batch_item* items = malloc(most * sizeof *items);
  char* block = malloc(BATCH_BYTES);
  uint32_t next = 0;
  while (items != NULL && block != NULL && next < most) {
    uint32_t count = 0;
    size_t used = 0;
    for (; next < most; ++next, ++count) {
      const render_want* w = &cache->wants[next];
      const render_asset* asset = &cache->sources[w->source].assets[w->asset];
      batch_item* item = &items[count];
      *item = (batch_item){.want = *w, .vertex_count = asset->vertices[w->lod], .index_count = 3 * asset->triangles[w->lod]};
      size_t vertex_bytes = round_up(item->vertex_count * sizeof(scree_vertex));
      size_t bytes = vertex_bytes + round_up(item->index_count * sizeof(uint16_t));
      if (bytes > BATCH_BYTES) {
        item->vertex_count = item->index_count = 0; /* no stone is as large: taken as broken */
        continue;
      }
      if (used + bytes > BATCH_BYTES) break;
      item->vertices = (scree_vertex*)(void*)(block + used);
      item->indices = (uint16_t*)(void*)(block + used + vertex_bytes);
      used += bytes;
    }
    batch b = {cache, items};
    if (cache->jobs.parallel_for != NULL)
      cache->jobs.parallel_for(cache->jobs.user, count, decode_item, &b);
    else
      for (uint32_t i = 0; i < count; ++i) decode_item(&b, i, 0);
    for (uint32_t i = 0; i < count; ++i) {
      const batch_item* item = &items[i];
      uint32_t row = RENDER_MESH_BROKEN;
      if (item->good) {
        row = render_meshes_add(&cache->sources[item->want.source].meshes, item->vertices, item->vertex_count, item->indices,
                                item->index_count);
        if (row == UINT32_MAX) row = RENDER_MESH_BROKEN;
      }
      set_row(cache, &item->want, row);
      ++cache->decoded;
    }
  }
  free(items);
  free(block);
  for (uint32_t i = next; i < cache->want_count; ++i) set_row(cache, &cache->wants[i], RENDER_MESH_ABSENT);
  uint32_t missing = cache->want_count - next;
  cache->want_count = 0;
  return missing;
}

uint32_t render_cache_mesh_count(const render_cache* cache) {
  uint32_t count = 0;
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) count += cache->sources[s].meshes.mesh_count;
  return count;
}

uint64_t render_cache_bytes(const render_cache* cache) {
  uint64_t bytes = 0;
  for (uint32_t s = 0; s < RENDER_SOURCES; ++s) {
    const render_meshes* m = &cache->sources[s].meshes;
    bytes += (uint64_t)m->vertex_count * sizeof(scree_vertex) + (uint64_t)m->index_count * sizeof(uint16_t);
  }
  return bytes;
}
