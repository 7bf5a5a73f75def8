/* A plain host of streams for tests: does what the events say, as a renderer would, and checks at each of them that it makes sense:
 * meshes come in before they are drawn and go out after, places of instances never overlap, no cap is ever passed. */
#ifndef SCREE_TESTS_STREAM_HOST_H
#define SCREE_TESTS_STREAM_HOST_H

#include <scree/stream.h>
#include <stdio.h>

#include "make_pack.h"

/* A pack with levels whose errors differ from rock to rock, and everything a scene of one layer needs. */
typedef struct stream_world {
  uint8_t* bytes;
  size_t size;
  scree_pack* pack;
  scree_field* field;
  scree_support* support;
  scree_scene* scene;
  scree_edits* edits;
} stream_world;

typedef struct stream_world_desc {
  bool proxies;
  uint32_t levels;     /* 0 = 3 */
  double origin;       /* of everything, all axes, metres */
  scree_shape* shapes; /* NULL: a round slab of some ten thousand rocks, and balls beside it */
  uint32_t shape_count;
  double cell_size; /* 0 = 1 */
} stream_world_desc;

void stream_world_make(stream_world* world, const stream_world_desc* desc);
void stream_world_free(stream_world* world);

/* The bytes of such a pack: to be freed with free(). */
uint8_t* stream_pack_make(bool proxies, uint32_t levels, uint64_t seed, size_t* size);

/* Decoders. The first fills a pattern that the host knows; the others fail, always or for a third of all meshes. */
scree_result stream_decode_pattern(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                   size_t vertex_capacity, uint16_t* indices, size_t index_capacity);
scree_result stream_decode_broken(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                  size_t vertex_capacity, uint16_t* indices, size_t index_capacity);
scree_result stream_decode_flaky(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                 size_t vertex_capacity, uint16_t* indices, size_t index_capacity);
bool stream_decode_fails(uint32_t asset, uint32_t lod); /* of the last one */

typedef struct host_mesh {
  bool in;
  const scree_pack* pack;
  uint32_t asset, level, users;
  uint64_t bytes;
} host_mesh;

typedef struct host_block {
  bool shown, leaving;
  uint32_t layer, level, first, count, run_count;
  double origin[3];
  float min[3], max[3];
  scree_stream_run runs[SCREE_STREAM_RUNS];
} host_block;

typedef struct stream_host {
  scree_stream* stream;
  scree_stream_desc desc;
  scree_stream_caps caps;
  const scree_pack* packs[8]; /* as they come */
  uint32_t* slots[8];         /* [asset * levels + level]: mesh slot, or UINT32_MAX */
  scree_pack_info infos[8];
  uint32_t pack_count;
  const scree_pack* layer_packs[64];
  host_mesh* meshes;
  uint32_t mesh_slots;
  host_block* blocks;
  scree_stream_instance* instances;
  scree_id* ids;
  uint32_t* owners; /* of places: block + 1, 0 = free */
  uint32_t shown_instances, shown_blocks;
  uint64_t mesh_bytes, uploaded;
  uint64_t events, digest; /* of all events and all they carry */
  uint64_t counts[5];      /* by kind */
  double time;
  bool void_coarsest; /* coarsest meshes may be missing */
} stream_host;

/* Makes the stream too. */
void host_create(stream_host* host, const scree_stream_desc* desc, const scree_allocator* allocator);
void host_destroy(stream_host* host);
/* The packs of a scene's layers, after create and after set_scene. */
void host_use_scene(stream_host* host, const scree_scene* scene);

/* One update, 1/60 s later, and all its events. */
void host_update(stream_host* host, const scree_view* views, uint32_t view_count);

/* Updates until nothing is under way and nothing happens any more; fails after `most`. Returns how many it took. */
uint32_t host_settle(stream_host* host, const scree_view* views, uint32_t view_count, uint32_t most);

/* A view of 60 degrees and 1080 pixels. */
scree_view host_view(double x, double y, double z);

/* All that must be true between two updates. Slow. */
void host_check(const stream_host* host);

/* What is shown, no far field, is what the scene says for all blocks within view_distance; levels are what the rule says where
 * `levels` is set. The stream has settled. */
void host_check_truth(const stream_host* host, const scree_view* views, uint32_t view_count, bool levels);

#endif
