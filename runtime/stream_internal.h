/* Streams from the inside: what the files stream*.c share. Each of them is one concept:
 *
 *   stream.c         create, destroy, set_scene, edited, and the order of an update
 *   stream_setup.c   what a stream makes of a scene: layers, packs, classes of assets; how much memory that takes
 *   stream_tree.c    the octrees: which nodes shall be shown, and in which order they are built
 *   stream_blocks.c  nodes that are shown: places in the array of instances, what goes in, is replaced and goes out
 *   stream_watch.c   which blocks have to be looked at because a view has moved
 *   stream_levels.c  the level of detail of every run of a block
 *   stream_meshes.c  which meshes are resident, who uses them, which come in and go out
 *   stream_tasks.c   builds and decodes, run by the host's tasks or at once
 *   stream_events.c  the events of an update and what may still be sent
 *   stream_ranges.c  free places of the array of instances
 *
 * How levels cost nothing per instance: at creation the assets of a pack fall into a few classes by the errors of their levels. The
 * instances of a block are sorted by class, so each class of a block is one run with one level, and whether that has to change is a
 * comparison of the block's distance with a small table. Only where a run changes are its instances touched, to count the users of
 * meshes; and not even then where all meshes of all packs fit into mesh_bytes.
 *
 * How an update of a slow camera costs almost nothing: `travel` is how far the views have ever moved. Every node keeps the travel
 * at which anything in its subtree can change at the earliest; the walk does not enter it before. */
#ifndef SCREE_STREAM_INTERNAL_H
#define SCREE_STREAM_INTERNAL_H

#include <scree/stream.h>
#include <stdatomic.h>

#include "allocator.h"
#include "field_tables.h"
#include "scene_internal.h"
#include "stream_ranges.h"

enum {
  STREAM_CLASSES = 8,
  STREAM_LEVELS = 8, /* no pack has more */
  STREAM_VIEWS = 8,
  STREAM_LAYERS = 64,
  STREAM_PACKS = 2 * STREAM_LAYERS, /* of a scene, and of scenes before it whose meshes have not yet gone out */
  STREAM_TOP = 24,                  /* highest level of a tree */
  STREAM_BLOCK_CUBES = 4,           /* a block is so many cubes wide */
  STREAM_PLANES = 8
};

#define STREAM_NONE UINT32_MAX

/* --- meshes ----------------------------------------------------------------------------------------------------------------- */

typedef enum mesh_state {
  MESH_OUT = 0,
  MESH_COMING, /* asked for: being decoded, or decoded and not yet sent */
  MESH_IN,
  MESH_VOID,  /* a coarsest level that cannot be read: counts as resident, has nothing to draw */
  MESH_FAILED /* a finer level that cannot be read: it is not asked for again */
} mesh_state;

/* A level of an asset. Its slot is first_mesh of its pack + asset * levels + level. */
typedef struct stream_mesh {
  uint32_t refs;          /* instances of runs that draw it or are about to */
  uint32_t before, after; /* while nothing refers to it: its place among such, the one unused for longest first */
  uint32_t vertices, triangles;
  uint8_t state;
  bool coarsest;
} stream_mesh;

typedef struct stream_pack {
  const scree_pack* pack;
  const scree_scatter* models; /* instead of a pack: models of the host's own, of one level, without meshes; both NULL: free */
  bool dead;                   /* of an earlier scene: never read, its meshes are on their way out */
  uint32_t assets, total;      /* rocks; rocks and proxies */
  uint32_t levels;
  uint32_t first_mesh, first_asset;                  /* in the tables of meshes and of classes */
  float error[2][STREAM_CLASSES][STREAM_LEVELS];     /* cells, of rocks and of proxies; never less at a coarser level */
  float far_error;                                   /* cells, of what is drawn as proxies */
  float low[3], high[3];                             /* how far rocks reach from the centre of their home cells, cells */
  float lattice[2];                                  /* cells a lattice step: of rocks, of proxies */
  uint32_t absent[2][STREAM_CLASSES][STREAM_LEVELS]; /* meshes of a class and level that cannot be drawn */
  uint64_t bytes;                                    /* of all meshes that can be asked for */
  uint32_t coarse_next[2];                           /* rocks, proxies below have their coarsest mesh */
  uint32_t meshes_in, blocks;                        /* resident meshes, blocks that are shown */
  uint64_t coarse_bytes, largest;                    /* all coarsest meshes; the largest mesh of all */
  uint32_t largest_vertices, largest_indices;
} stream_pack;

/* --- layers and nodes ------------------------------------------------------------------------------------------------------- */

typedef struct stream_layer {
  const scree_field* field;
  uint32_t pack;   /* index in packs */
  double low[3];   /* low corner of cube 0, world */
  double cube;     /* width, metres */
  float cell;      /* metres */
  float largest;   /* of a scatter's sizes; 1 for rocks */
  float radius;    /* metres: what stands in a scatter reaches no farther; 0 for rocks */
  bool far_field;  /* its pack has proxies, and they are wanted */
  uint32_t root;   /* first of its roots, or STREAM_NONE */
  uint32_t top;    /* level of its roots */
  double root_due; /* travel at which another root may be wanted */
  double reach;    /* scree_rt_scene_reach */
} stream_layer;

typedef struct stream_node {
  double due;           /* travel at which something in its subtree may change */
  double child_due[8];  /* the same of its children, or when they may come into view; while child_context holds */
  uint64_t touched;     /* when a change of the scene or of edits last concerned it; see scree_stream.touch */
  int32_t at[3];        /* in widths of its own level */
  uint32_t parent;      /* STREAM_NONE: a root */
  uint32_t child[8];    /* x + 2 y + 4 z, or STREAM_NONE */
  uint32_t next;        /* root, or free node */
  uint32_t block;       /* what it shows; STREAM_NONE: nothing, because it is not shown or because there is nothing to see */
  uint32_t fresh;       /* what was built and is not shown yet; likewise */
  uint32_t generation;  /* of the place in the pool: builds for an earlier one are dropped */
  uint32_t shown_below; /* nodes of its subtree that are shown, itself among them */
  uint32_t hole_at;     /* its place in the list of holes, or STREAM_NONE */
  uint16_t layer;
  uint8_t level;
  uint8_t empty; /* bit i: child i can hold nothing */
  uint8_t context, child_context;
  bool shown, ready; /* ready: fresh is the answer of a build */
  bool building, stale, split;
  bool opened;  /* it was shown and its children have taken its place */
  bool first;   /* it came when its tree showed nothing: it may show itself before its children, though not all of it is in view */
  bool refused; /* a cap forbids it for ever: counts as shown, shows nothing */
} stream_node;

/* --- blocks ----------------------------------------------------------------------------------------------------------------- */

/* What a block shows. Its runs are what events carry; beside each is what the rule wants. */
typedef struct stream_block {
  double origin[3];
  float min[3], max[3];
  float cell, largest; /* of its layer */
  uint32_t first, count;
  uint32_t node; /* STREAM_NONE once it has left the tree and only fades out */
  uint16_t layer, pack;
  uint8_t level, run_count;
  bool shown, leaving, unused;
  uint8_t run_class[STREAM_CLASSES];
  uint8_t aim[STREAM_CLASSES];      /* level by the rule, with hysteresis and under the bound on meshes */
  uint8_t ideal[STREAM_CLASSES];    /* level by the rule alone */
  uint8_t barred[STREAM_CLASSES];   /* bit l: level l has a mesh that cannot be read */
  uint8_t goal[STREAM_CLASSES];     /* level for which users are being counted in advance */
  uint32_t counted[STREAM_CLASSES]; /* so many instances of the run */
  scree_stream_run runs[STREAM_CLASSES];
  float fade_start;
  uint32_t coarser;                                  /* instances drawn coarser than the rule says */
  uint32_t waiting_at;                               /* place in the list of blocks that wait for meshes, or STREAM_NONE */
  uint32_t fading_at;                                /* place in the list of blocks that fade, or STREAM_NONE */
  uint32_t next;                                     /* free slot */
  uint64_t sent;                                     /* update of its last event */
  uint32_t triangles[STREAM_CLASSES][STREAM_LEVELS]; /* of all instances of a run */
} stream_block;

/* A block that waits for meshes, and the error on the screen of what it draws meanwhile. */
typedef struct stream_wait {
  uint32_t block;
  float urgency;
} stream_wait;

/* --- tasks ------------------------------------------------------------------------------------------------------------------ */

typedef struct stream_task {
  struct scree_stream* stream;
  void (*work)(struct stream_task* task);
  atomic_bool done;
} stream_task;

typedef struct stream_build {
  stream_task task;
  /* question */
  uint32_t node, generation;
  uint64_t touch;
  uint32_t layer, level;
  int32_t low[3], high[3];
  double origin[3];
  uint32_t slot, label;  /* block that is kept for it, or STREAM_NONE; what its instances say for their block */
  uint32_t first, place; /* places in the array of instances that are kept for it */
  /* answer */
  scree_result result;
  uint32_t count, class_first[STREAM_CLASSES + 1];
  uint32_t triangles[STREAM_CLASSES][STREAM_LEVELS];
  float min[3], max[3];
  scree_scratch* scratch;
  scree_stream_instance* instances; /* sorted by class, then asset: in the stream's array if that is where they fit */
  scree_id* ids;
  bool placed; /* they did */
  scree_stream_instance* own_instances;
  scree_id* own_ids;
  uint64_t* keys; /* 2 * capacity */
  uint32_t capacity;
} stream_build;

typedef struct stream_decode {
  stream_task task;
  uint32_t pack, asset, level, mesh;
  scree_result result;
  scree_vertex* vertices;
  uint16_t* indices;
  bool sent; /* its buffers are in an event until the next update */
} stream_decode;

/* Tasks under way, in the order in which they were submitted, and those that are free. Numbers of builds or decodes. */
typedef struct stream_queue {
  uint32_t *order, *free;
  uint32_t count, free_count;
} stream_queue;

/* --- the stream ------------------------------------------------------------------------------------------------------------- */

typedef struct stream_view {
  double position[3];
  double pixels; /* of one metre at one metre's distance */
  double ratio;  /* largest pixels of all views over its own, >= 1 */
  float planes[STREAM_PLANES][4];
  uint32_t plane_count;
} stream_view;

/* When a bound may be relaxed: travels. */
typedef struct stream_bound {
  double wait;    /* not before this while views move */
  double relaxed; /* up to here it counts as relaxed not long ago */
  double refused; /* that was too much: not before this */
} stream_bound;

/* A node that shall be built, and how soon: the least first. */
typedef struct stream_want {
  double order;
  uint32_t node;
} stream_want;

struct scree_stream {
  scree_allocator allocator;
  scree_stream_desc desc; /* with all defaults filled in */
  void* memory;           /* everything of fixed size that follows */
  size_t memory_size;

  const scree_scene* scene;
  uint32_t layer_count;
  stream_layer layers[STREAM_LAYERS];
  uint32_t grave; /* roots of layers that are gone */
  stream_pack packs[STREAM_PACKS];

  /* Tables of meshes and classes; they grow when a scene brings packs. */
  stream_mesh* meshes;
  uint8_t* classes; /* of assets */
  uint32_t mesh_slots, asset_slots;
  uint32_t mesh_capacity, asset_capacity;
  scree_vertex* decode_vertices; /* 2 * decodes meshes of the largest size */
  uint16_t* decode_indices;
  size_t decode_vertex_room, decode_index_room; /* of one */
  bool roomy;                     /* all meshes of all packs fit: users are not counted, because nothing ever has to go */
  uint32_t idle_first, idle_last; /* meshes that are in and unused */
  uint64_t mesh_bytes, coming_bytes, idle_bytes;
  uint32_t meshes_in;
  uint8_t* staging; /* of coarsest meshes of one update */
  size_t staging_size, staging_low, staging_high;

  /* Views. */
  stream_view views[STREAM_VIEWS];
  uint32_t view_count;
  double travel;
  double pixels; /* the largest of all views */
  double time;
  bool revisit, revisit_next; /* what is due does not count in this update, in the next */

  /* Trees. */
  stream_node* nodes;
  uint32_t node_count, node_used, free_node;
  uint32_t *holes, hole_count; /* nodes that may hold something and show nothing, nor does what is above or below them */
  stream_want* wants;          /* a heap, the last to be built at its top */
  uint32_t want_count, want_room;
  uint32_t pending;    /* nodes that are not what they shall be */
  uint32_t expansions; /* nodes that may still be looked at for the first time in this update */
  uint64_t touch;      /* counts changes of the scene and of edits */

  /* Bounds that tighten when a cap binds. */
  double view_limit;  /* metres: nothing farther is shown */
  double split_scale; /* >= 1: proxies may be so much coarser */
  double mesh_scale;  /* >= 1: levels may be so much coarser */
  bool short_of_room, short_of_meshes;
  stream_bound room_bound, mesh_bound;

  /* Blocks. */
  stream_block* blocks;
  uint32_t free_block, blocks_used, blocks_free, blocks_shown;
  stream_ranges ranges;
  scree_stream_instance* instances;
  scree_id* ids;
  uint32_t* owners;  /* block that is shown, or was, for each unit of ranges; STREAM_NONE: none so far */
  uint32_t usual[2]; /* instances that seven in eight blocks of rocks, of proxies, have at most: places that are kept for a build */
  stream_wait* waiting;
  uint32_t waiting_count, waiting_next;
  uint32_t *fading, fading_count;
  float* watches; /* see stream_watch.c */
  double anchor[3], watched_travel;
  uint32_t *moved, moved_count; /* blocks whose aims have changed in this update */

  /* Tasks. */
  stream_build* builds;
  stream_decode* decodes;
  stream_queue build_queue, decode_queue;
  uint32_t *queue_words, *range_words; /* memory of the queues, of the ranges */
  uint32_t decodes_under_way;

  /* Events. */
  scree_event* events;
  uint32_t event_count;
  uint64_t upload_bytes;
  uint64_t update; /* number of the update */

  /* Sums over what is shown. */
  uint32_t shown_instances, shown_by_level[STREAM_LEVELS], shown_proxies, coarser, refused;
  uint64_t triangles;
};

/* Says that bytes are going to be needed. */
static inline void stream_prefetch(const void* bytes, size_t size) {
#if defined(__GNUC__)
  for (size_t at = 0; at < size; at += 64) __builtin_prefetch((const char*)bytes + at);
#else
  (void)bytes, (void)size;
#endif
}

static inline bool stream_pack_is_used(const stream_pack* pack) {
  return pack->pack != NULL || pack->models != NULL;
}

static inline uint32_t stream_mesh_slot(const stream_pack* pack, uint32_t asset, uint32_t level) {
  return pack->first_mesh + asset * pack->levels + level;
}

static inline uint64_t stream_mesh_bytes(const stream_mesh* mesh) {
  return (uint64_t)mesh->vertices * sizeof(scree_vertex) + (uint64_t)mesh->triangles * 3 * sizeof(uint16_t);
}

static inline bool stream_mesh_usable(const stream_mesh* mesh) {
  return mesh->state == MESH_IN || mesh->state == MESH_VOID;
}

/* Width of a node, metres. */
static inline double stream_node_width(const stream_layer* layer, uint32_t level) {
  return layer->cube * (double)((uint64_t)STREAM_BLOCK_CUBES << level);
}

static inline void stream_node_low(const stream_layer* layer, uint32_t level, const int32_t at[3], double low[3]) {
  double width = stream_node_width(layer, level);
  for (int a = 0; a < 3; ++a) low[a] = layer->low[a] + (double)at[a] * width;
}

/* stream_setup.c */
/* Checks a descriptor and fills in the defaults. */
scree_result scree_rt_stream_check(scree_stream_desc* desc, scree_error* error);
/* Packs and tables for a scene; on failure nothing has changed. Layers that `kept` has bits for stay as they are. */
scree_result scree_rt_stream_set_up(scree_stream* stream, const scree_scene* scene, uint64_t kept, scree_error* error);
void scree_rt_stream_drop_tables(scree_stream* stream);
/* Bytes of the tables, or 0 if the packs cannot be used. */
size_t scree_rt_stream_tables_size(const scree_stream_desc* desc);

/* stream_events.c */
bool scree_rt_stream_can_send(const scree_stream* stream, uint32_t events, uint64_t bytes);
scree_event* scree_rt_stream_send(scree_stream* stream, scree_event_kind kind, uint64_t bytes);

/* stream_meshes.c */
void scree_rt_stream_mesh_use(scree_stream* stream, uint32_t mesh);
void scree_rt_stream_mesh_leave(scree_stream* stream, uint32_t mesh);
/* Asks for a mesh; false when that has to wait. */
bool scree_rt_stream_mesh_ask(scree_stream* stream, uint32_t pack, uint32_t asset, uint32_t level);
/* Counts all users of all meshes anew, after a scene has brought or taken packs. */
void scree_rt_stream_meshes_recount(scree_stream* stream);
/* Sends coarsest meshes and what has been decoded; lets go of what is unused where room is short. */
void scree_rt_stream_meshes_send(scree_stream* stream);
/* Whether the pack still says of a mesh what it said when the stream was made: its bytes may have changed since. */
bool scree_rt_stream_mesh_fits(const scree_pack* pack, uint32_t asset, uint32_t level, const stream_mesh* mesh);
/* Whether the coarsest meshes of what nodes of a layer and level show are all in. */
bool scree_rt_stream_coarsest_are_in(const scree_stream* stream, uint32_t layer, uint32_t level);

/* stream_levels.c */
static inline uint64_t stream_run_bytes(const stream_block* block) {
  return block->run_count * sizeof(scree_stream_run);
}
/* What the rule wants of a shown block now; delivers the scaled distances between which that stays. */
void scree_rt_stream_levels_aim(scree_stream* stream, uint32_t block, double* near, double* far);
/* Chooses the levels of a block that comes in, and counts it as a user of their meshes. */
void scree_rt_stream_levels_start(scree_stream* stream, uint32_t block, bool fades);
/* It only fades out from now on. */
void scree_rt_stream_levels_fade_out(scree_stream* stream, uint32_t block);
/* The block is no longer drawn. */
void scree_rt_stream_levels_end(scree_stream* stream, uint32_t block);
/* Counts a shown block as a user of its meshes once more. */
void scree_rt_stream_levels_recount(scree_stream* stream, uint32_t block);
/* Brings runs to their levels, asks for meshes, ends fades. */
void scree_rt_stream_levels_update(scree_stream* stream);

/* stream_watch.c */
/* Numbers that watching takes are twelve such rows. */
uint32_t scree_rt_stream_watch_rows(const scree_stream_caps* caps);
void scree_rt_stream_watch_init(scree_stream* stream);
/* The levels of a block stay between two scaled distances. */
void scree_rt_stream_watch(scree_stream* stream, uint32_t block, double near, double far);
void scree_rt_stream_unwatch(scree_stream* stream, uint32_t block);
/* Looks at the blocks that are due; at all if `anew`. */
void scree_rt_stream_watch_update(scree_stream* stream, bool anew);

/* stream_blocks.c */
/* Keeps a block and places for a build where there is plenty of room, so that its task can put the instances where they belong. */
void scree_rt_stream_keep_place(scree_stream* stream, stream_build* build);
/* Takes in what a build found: the node's `fresh`. */
void scree_rt_stream_take_build(scree_stream* stream, stream_build* build);
uint64_t scree_rt_stream_fresh_bytes(const scree_stream* stream, const stream_node* node);
/* All below: the caller has made sure that the events can be sent. */
void scree_rt_stream_show(scree_stream* stream, uint32_t node);
void scree_rt_stream_hide(scree_stream* stream, uint32_t node);
void scree_rt_stream_replace(scree_stream* stream, uint32_t node);
void scree_rt_stream_drop_fresh(scree_stream* stream, stream_node* node);
scree_event* scree_rt_stream_send_block(scree_stream* stream, scree_event_kind kind, uint32_t block, uint64_t bytes);
/* A block that has faded out, or that has to go at once, goes. */
void scree_rt_stream_block_out(scree_stream* stream, uint32_t block);

/* stream_tree.c */
void scree_rt_stream_tree_update(scree_stream* stream);
/* Tightens or relaxes the bounds, at the end of an update. */
void scree_rt_stream_bound(scree_stream* stream);
/* Nodes of layer `layer` that a world box meets are built again. NULL: all. */
void scree_rt_stream_touch(scree_stream* stream, uint32_t layer, const double min[3], const double max[3]);
/* The trees of a layer are going to be emptied. */
void scree_rt_stream_bury(scree_stream* stream, uint32_t layer);
/* A block has left the view, or may have. */
void scree_rt_stream_node_due(scree_stream* stream, uint32_t node);
/* Nearest distance from any view to a box, metres; scaled: in pixels of the sharpest view. */
double scree_rt_stream_distance(const scree_stream* stream, const double low[3], const double high[3], double* scaled);
/* How far from the views the nearest hole is, metres; view_distance at most. */
double scree_rt_stream_covered(const scree_stream* stream);

/* stream_tasks.c */
scree_result scree_rt_stream_tasks_init(scree_stream* stream);
size_t scree_rt_stream_scratch_size(void); /* of one build, before it has been used */
void scree_rt_stream_tasks_destroy(scree_stream* stream);
bool scree_rt_stream_build_start(scree_stream* stream, uint32_t node);
bool scree_rt_stream_decode_start(scree_stream* stream, uint32_t pack, uint32_t asset, uint32_t level);
/* Waits for all that is under way. */
void scree_rt_stream_tasks_wait(scree_stream* stream);
/* Takes in what is done, in the order of submission. */
void scree_rt_stream_tasks_collect(scree_stream* stream);

#endif
