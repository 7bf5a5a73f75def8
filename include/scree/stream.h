/* A stream: which rocks, at which level of detail, a renderer has to hold for where its cameras are. Views go in, ordered events
 * come out; the host owns the GPU and does what the events say. Nothing is ever shown that the caps do not allow, and within
 * them nothing near is missing: a block of rocks appears when its coarsest meshes are there, a mesh that is late is drawn one level
 * coarser.
 *
 *   octree of each layer, in its own cubes                 what a node shows
 *     level 0   block of 4 x 4 x 4 cubes                   rocks
 *     level 1   8 x 8 x 8 cubes                            proxies of whole tiles and of their eighths
 *     level 2   16 x 16 x 16 cubes                         proxies twice as large, each for 2 x 2 x 2 cubes
 *     level l   ...                                        proxies 2^(l-1) times as large
 *
 * A layer that is a scatter has rocks only, which are its models, on all of the way to view_distance. Where they are the host's
 * own, no mesh events come for them and all their runs have level 0.
 *
 * A node is replaced by its children where its error on the screen, that of seven in eight proxies of the pack but at least an
 * eighth of their cube's width, is more than max_error_pixels. Levels of rocks follow the same rule: the coarsest level whose
 * error, seen from the nearest point of the rock's block, is at most max_error_pixels; to go back to a coarser one the error has to
 * be below max_error_pixels / (1 + hysteresis). The error of a level is the largest among the rocks of its class, rounded up by at
 * most a quarter: those of a pack fall into eight by their errors, and all of them change levels at the same few distances. */
#ifndef SCREE_STREAM_H
#define SCREE_STREAM_H

#include "scene.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_stream scree_stream;

/* Decodes a level of a rock or proxy: scree_draco_decode_u16 is one. Called from the calling thread or from tasks. */
typedef scree_result (*scree_decode_fn)(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_vertex* vertices,
                                        size_t vertex_capacity, uint16_t* indices, size_t index_capacity);

/* What a stream may use. 0 = the default in brackets. No cap is ever passed, not by one byte, not for one update. The largest need
 * that scree-bench-stream shows is a view of 300 m over a mountain of half-metre stones, one metre deep: some five million
 * instances in nine thousand blocks. With the defaults the farther part of that view is drawn as proxies, without a hole. */
typedef struct scree_stream_caps {
  uint32_t instances;    /* in blocks that are shown, those that fade in or out among them [1,048,576] */
  uint32_t blocks;       /* shown [16,384] */
  uint64_t mesh_bytes;   /* resident meshes, vertices and indices, as the host stores them [256 MiB] */
  uint64_t upload_bytes; /* of one update: meshes, instances and runs of its events; what is larger alone never comes in [8 MiB] */
  uint32_t decodes;      /* meshes being decoded at once, and so the most that can come in in one update [64] */
  uint32_t builds;       /* blocks being built at once [64] */
  uint32_t events;       /* of one update [16,384] */
} scree_stream_caps;

typedef struct scree_stream_desc {
  const scree_scene* scene; /* must outlive the stream, or the next scree_stream_set_scene */
  const scree_edits* edits; /* or NULL; see scree_stream_edited */
  double view_distance;     /* metres, > 0: what is shown are the blocks whose box of home cells is nearer than that to a view */
  float max_error_pixels;   /* of meshes on the screen; 0 = 1 */
  float hysteresis;         /* share, >= 0; 0 = 0.1; see above */
  float fade_seconds;       /* of a change of level; 0 = none: at once */
  bool no_far_field;        /* rocks as far as view_distance, no proxies */
  bool deterministic; /* the same events for the same calls, whatever the tasks: background work of one update ends in the next */
  scree_stream_caps caps;
  scree_decode_fn decode; /* NULL: only coarsest levels are shown */
  scree_tasks tasks;      /* all zero: everything happens in scree_stream_update */
  scree_log log;
} scree_stream_desc;

/* Memory of a stream: 42 bytes an instance, about 1,000 a block, 128 an event, 24 for each level of each asset of each pack, for
 * each decode twice the largest mesh of the packs, and the coarsest meshes of all packs, but no more than upload_bytes;
 * scree_stream_memory gives the exact sum for a descriptor, 0 for a wrong one. All of it is allocated here, but for the scratch of
 * builds, which grows with the densest block.
 * Returns SCREE_OK, INVALID_ARGUMENT (also a field without a pack), RANGE, CORRUPT, CAPACITY (mesh_bytes does not hold the coarsest
 * levels of all assets, or upload_bytes not the largest of them; error says how many bytes that takes) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_stream_create(const scree_stream_desc* desc, const scree_allocator* allocator, scree_stream** out,
                                           scree_error* error);
SCREE_API size_t scree_stream_memory(const scree_stream_desc* desc);

/* Waits for background work, frees everything. NULL is allowed. */
SCREE_API void scree_stream_destroy(scree_stream* stream);

typedef struct scree_view {
  double position[3];    /* world, metres */
  float field_of_view;   /* vertical, radians, > 0 and < pi */
  float viewport_height; /* pixels, > 0 */
  const float* frustum; /* NULL, or 4 * plane_count floats a, b, c, d: inside is where a x + b y + c z + d >= 0 for all planes, with
                           (x, y, z) relative to the position. What is outside comes after what is inside */
  uint32_t plane_count; /* 0..8 */
} scree_view;

/* One instance, 24 bytes. */
typedef struct scree_stream_instance {
  float position[3]; /* metres, relative to the block's origin */
  uint32_t asset;    /* of the pack: a rock, or from asset_count on a proxy; of a scatter, the model */
  uint32_t random;   /* for colour and wetness: scree_scene_random; of a scatter also turn and size: scree_scatter_turn */
  uint32_t block;    /* slot of its block, below caps.blocks */
} scree_stream_instance;

/* Instances of one block that share a level; a block has at most SCREE_STREAM_RUNS. While they fade, both levels are drawn,
 * dithered: level with the share that scree_stream_fade gives, from_level with the rest. */
#define SCREE_STREAM_RUNS 8
typedef struct scree_stream_run {
  uint32_t first, count; /* in the stream's array of instances */
  uint8_t level;         /* to be drawn */
  uint8_t from_level;    /* fading out; 255 = nothing */
  uint16_t padding;      /* 0 */
  float fade_start;      /* time of the update at which it began, seconds; see scree_stream_fade */
} scree_stream_run;

typedef enum scree_event_kind {
  SCREE_EVENT_MESH_IN = 0,      /* a mesh to be uploaded */
  SCREE_EVENT_MESH_OUT = 1,     /* a mesh that no block uses any longer */
  SCREE_EVENT_BLOCK_IN = 2,     /* a block to be drawn: its instances and runs are new */
  SCREE_EVENT_BLOCK_CHANGE = 3, /* its runs have changed; its instances too where `instances` is not NULL */
  SCREE_EVENT_BLOCK_OUT = 4
} scree_event_kind;

typedef struct scree_event_mesh {
  const scree_pack* pack;
  uint32_t asset, level;
  uint32_t mesh;                /* the mesh's slot: always the same while a layer uses the pack; below scree_stream_mesh_slots */
  const scree_vertex* vertices; /* IN only, valid until the next call with this stream */
  const uint16_t* indices;
  uint32_t vertex_count, index_count;
} scree_event_mesh;

typedef struct scree_event_block {
  uint32_t block;       /* its slot, stable while it is shown */
  uint32_t layer;       /* index in the scene */
  uint32_t level;       /* 0: rocks; more: proxies */
  double origin[3];     /* world place that the positions of its instances are relative to, metres */
  float scale;          /* metres a lattice step: vertex.position * scale + instance.position; of a scatter at size
                           1, before its turn and size; of models of the host's own 1 */
  float min[3], max[3]; /* box of everything it draws, relative to its origin, metres */
  uint32_t first_instance, instance_count; /* its place in the stream's array of instances */
  const scree_stream_instance*
      instances;                /* IN, and CHANGE after edits: instance_count, valid until the next call; otherwise NULL */
  const scree_id* ids;          /* beside instances: what each is; of a proxy, its cube at its level */
  const scree_stream_run* runs; /* IN and CHANGE: all its runs, in order, valid until the next call */
  uint32_t run_count;
  float fade_start; /* BLOCK_IN with fading: it fades in from then on; BLOCK_CHANGE with `leaving`: it fades out */
  bool leaving;
} scree_event_block;

/* What has to be done; `kind` says which member holds. */
typedef struct scree_event {
  scree_event_kind kind;
  union {
    scree_event_mesh mesh;
    scree_event_block block;
  };
} scree_event;

/* Moves the views and delivers what has to change since the last call, in the order in which it has to be done: a mesh comes in
 * before the first run that draws it and goes out after the last. views: `view_count`, 0..8; with none, everything goes out. time:
 * seconds, never less than before; only fades look at it. events: valid until the next call with this stream. When a cap binds, in
 * this order: finer levels come later or not at all, the farthest first; the farthest blocks are drawn as proxies; the farthest are
 * not drawn; what gave way comes back, a little at a time, when there is room. Returns SCREE_OK or INVALID_ARGUMENT (nothing
 * has changed then). Bad bytes in a pack cost meshes, not the stream: the log is told once a mesh, and the rocks of its class in a
 * block stay at the coarser level. Not to be called from two threads at once. Allocates nothing in steady state. */
SCREE_API scree_result scree_stream_update(scree_stream* stream, const scree_view* views, uint32_t view_count, double time,
                                           const scree_event** events, uint32_t* event_count);

/* Share of a run's `level`, 0..1, at a time. */
SCREE_API float scree_stream_fade(const scree_stream* stream, float fade_start, double time);

/* The same rocks with other supports, filters or layers: blocks that the change can touch are built again in the next updates, all
 * others stay to the bit. A layer is the same layer if key, field, scatter and place in the order are. The old scene is not used
 * after the call. Returns SCREE_OK, INVALID_ARGUMENT, CAPACITY (as create; nothing has changed) or OUT_OF_MEMORY. */
SCREE_API scree_result scree_stream_set_scene(scree_stream* stream, const scree_scene* scene);

/* Says that the edits of these rocks have changed; blocks that show them or their neighbours are built again. count 0: all may
 * have. Edits must not be changed while background builds run: call scree_stream_wait first. */
SCREE_API scree_result scree_stream_edited(scree_stream* stream, const scree_id* ids, uint32_t count);

/* Waits for all background work; the next update delivers it. */
SCREE_API void scree_stream_wait(scree_stream* stream);

/* Mesh slots are numbered below this. It may grow when a scene brings packs. */
SCREE_API uint32_t scree_stream_mesh_slots(const scree_stream* stream);

/* The slot of the mesh that instances of a layer draw, by asset and by level of their run: what scree_event_mesh.mesh says when it
 * comes in, so that a host needs no table. Always the same while a layer uses the pack; UINT32_MAX for what the layer's pack does
 * not have and for models of the host's own. */
SCREE_API uint32_t scree_stream_mesh(const scree_stream* stream, uint32_t layer, uint32_t asset, uint32_t level);

typedef struct scree_stream_stats {
  uint32_t instances, blocks, meshes; /* shown, resident */
  uint32_t instances_by_level[8];     /* of rocks; proxies apart */
  uint32_t proxies;
  uint64_t mesh_bytes, upload_bytes; /* resident; of the last update */
  uint64_t triangles;                /* of all that is shown, at its levels */
  uint32_t decodes, builds;          /* under way */
  uint32_t coarser;                  /* instances drawn coarser than the rule says, for want of their mesh */
  uint32_t degraded;                 /* 0 unless a cap binds: blocks are drawn as proxies, or not at all, for want of room */
  double covered; /* metres: all that is nearer to a view shows rocks or proxies, or has none; view_distance at most */
  bool complete;  /* nothing is under way and nothing is missing */
} scree_stream_stats;

/* What is shown as of the last update. */
SCREE_API void scree_stream_get_stats(const scree_stream* stream, scree_stream_stats* out);

/* The rock behind an instance that is shown, by its place in the stream's array: its layer, and its id; false for a proxy or a
 * place that is not in use. */
SCREE_API bool scree_stream_id(const scree_stream* stream, uint32_t instance, scree_id* id);

#ifdef __cplusplus
}
#endif

#endif
