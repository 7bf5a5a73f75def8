/* A pack: the baked file, opened and used in place. The bytes are described in docs/pack_format.md; this header is how a
 * program reads them. A reader trusts nothing: a wrong offset, count or value gives a result code, in every build. */
#ifndef SCREE_PACK_H
#define SCREE_PACK_H

#include "base.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct scree_pack scree_pack;

/* A vertex of a mesh, 16 bytes, ready for a vertex buffer. */
typedef struct scree_vertex {
  int16_t position[3]; /* lattice steps relative to the home cell's centre, of a model to the middle of its ground, of a block of a
                          cliff to its centroid; times cell_size / lattice_per_cell = metres */
  uint8_t occlusion;   /* ambient visibility, 255 = open sky, 0 = wholly hidden; linear */
  uint8_t material;    /* low 4 bits: 0 = rock, 1 = colluvium, 2 = a cut face, of cliffs only; high 4 bits: the bed, 0..15, see
                          scree_surface_vertex.layer */
  int16_t normal[3];   /* unit normal, signed normalised: value / 32767 */
  uint8_t durability;  /* of the rock beneath: 4 * value / 255, where 255 also means more; 0 in packs of tiles */
  int8_t curvature;    /* -127..127 = -1..1: < 0 = hollows, > 0 = edges and tips; 0 in packs of tiles */
} scree_vertex;

/* Opens a pack that lies in memory. Checks the header and the section table only, so the cost does not depend on the number
 * of assets; everything else is checked where it is read.
 *
 * bytes: `size` bytes, 8-byte aligned, which must stay unchanged until scree_pack_close; they are not copied.
 * out: the pack, to be closed with scree_pack_close with the same allocator alive.
 * allocator: NULL for malloc and free.
 * Returns SCREE_OK, or NOT_A_PACK, VERSION, TRUNCATED, CORRUPT, DIGEST (of the header or the section table), INVALID_ARGUMENT
 * (bytes not aligned), OUT_OF_MEMORY. On failure *out is NULL. Thread safety: an open pack is immutable; any number of threads may
 * read it. */
SCREE_API scree_result scree_pack_open_memory(const void* bytes, size_t size, const scree_allocator* allocator, scree_pack** out);

/* Maps a file and opens it as above; also returns SCREE_ERROR_IO. The file must not change while the pack is open: to replace
 * it, write another one and rename that. Bytes that change all the same cost meshes and hulls; a file that becomes shorter ends the
 * program where the system ends it. */
SCREE_API scree_result scree_pack_open_file(const char* path, const scree_allocator* allocator, scree_pack** out);

/* Closes a pack; NULL is allowed. Fields made from it must be gone. */
SCREE_API void scree_pack_close(scree_pack* pack);

/* Reads every byte and checks every digest that can be checked without decoding meshes: section digests and the pack digest.
 * Returns SCREE_OK, SCREE_ERROR_DIGEST or SCREE_ERROR_CORRUPT. */
SCREE_API scree_result scree_pack_verify(const scree_pack* pack);

/* What a pack holds. */
typedef enum scree_pack_kind {
  SCREE_PACK_TILES = 0,  /* rocks that fill tiles: for fields */
  SCREE_PACK_MODELS = 1, /* models that stand by themselves, hoodoos for instance: variants, each in several ages. A cell is a metre
                            at scale 1, and variants and ages take the places of cells and seeds */
  SCREE_PACK_CLIFF = 2   /* a cliff that frost splits, and the blocks that fell: models too, with times and placements */
} scree_pack_kind;

typedef struct scree_pack_info {
  uint32_t format_version;
  scree_pack_kind kind;
  uint32_t cells_per_cube;     /* N, cells per side of a corner cube; the recipe's and the paper's n is N + 1; 0 for models */
  uint32_t lattice_per_cell;   /* lattice steps per cell: a vertex at `v` lies v / lattice_per_cell cells from its cell's centre */
  uint32_t cell_count;         /* unique cells: 2 + 12(N-1) + 48(N-1)^2 + 256(N-1)^3; for models, variants */
  uint32_t variant_count;      /* of models, of a cliff 1 + its blocks; 0 in packs of tiles */
  uint32_t time_count;         /* of a cliff: times at which it was kept, which are the ages of variant 0; else 0 */
  uint32_t placement_count;    /* of a cliff: of all times together; else 0 */
  uint32_t asset_count;        /* unique rocks; models, which are all ages of all variants */
  uint32_t lod_count;          /* levels of every asset, finest first, >= 1 */
  uint32_t proxy_count;        /* merged meshes of tiles, numbered from asset_count on: 256 * 9, or 0 */
  uint32_t proxy_per_cell;     /* lattice steps per cell of their vertices */
  uint32_t max_rocks_per_cell; /* seeds are numbered below this, so no cell has more rocks, and no variant more ages; >= 1 */
  float max_radius;            /* largest outer radius of all assets, cells */
  float uv_min[2], uv_max[2];  /* of a cliff: what the values 0 and 65535 of a scree_uv stand for; else 0 */
  uint64_t digest;             /* of everything baked, however it was encoded; compare this between builds */
  const char* recipe;          /* the recipe's JSON, NUL-terminated, owned by the pack */
  size_t recipe_size;          /* without the NUL */
  size_t file_size;            /* bytes */
} scree_pack_info;

/* What the header of a pack says. Thread-safe. */
SCREE_API void scree_pack_get_info(const scree_pack* pack, scree_pack_info* out);

/* One section of the file, for tools that show what a pack is made of. */
typedef struct scree_pack_section {
  const char* name;  /* as in docs/pack_format.md, static storage */
  uint64_t size;     /* bytes */
  uint64_t elements; /* of fixed size */
  uint64_t digest;   /* XXH3-64 of its bytes, as the file says; scree_pack_verify checks it */
} scree_pack_section;

#define SCREE_PACK_SECTIONS 14 /* at most: those of cliffs; packs of tiles have the first 9, those of models the first 11 */

/* index: 0..SCREE_PACK_SECTIONS - 1. Returns SCREE_OK, or INVALID_ARGUMENT, also for a section that packs of this kind lack. */
SCREE_API scree_result scree_pack_get_section(const scree_pack* pack, uint32_t index, scree_pack_section* out);

/* One rock, without its meshes. Lengths in cells, positions relative to the centre of the rock's home cell. Models have this record
 * too, with variant and age as cell and seed, metres for cells and no contacts; see scree_pack_get_model. */
typedef struct scree_asset {
  uint32_t cell;          /* unique cell this rock belongs to */
  uint32_t seed;          /* which of the cell's seeds */
  float bounds_min[3];    /* of LOD 0 */
  float bounds_max[3];    /* of LOD 0 */
  float centroid[3];      /* centre of mass */
  float volume;           /* cubic cells */
  float inner_radius;     /* ball around the centroid that lies inside the rock */
  float outer_radius;     /* ball around the centroid that holds the rock */
  uint32_t contact_count; /* contacts with neighbours */
  uint32_t hull_vertices; /* vertices of the convex hull, 4..64 */
  uint32_t burial; /* b: while every rock of the (2b + 1)^3 cells round its own exists, next to nobody sees it from outside: of the
                      thousands of lines of sight from its surface that the bake follows, rocks of the (2b - 1)^3 cells stop every
                      one; 1..SCREE_BURIAL_NEVER - 1, or SCREE_BURIAL_NEVER: no such b is known, as of models */
} scree_asset;

#define SCREE_BURIAL_NEVER 7

/* Returns SCREE_OK, INVALID_ARGUMENT (asset out of range) or CORRUPT. */
SCREE_API scree_result scree_pack_get_asset(const scree_pack* pack, uint32_t asset, scree_asset* out);

/* One level of detail of one rock. */
typedef struct scree_lod {
  uint32_t vertices;  /* as decoded */
  uint32_t triangles; /* >= 1; a level that would be too coarse for a rock repeats the one before it */
  float error; /* of a rock: largest distance from a vertex of LOD 0 to this level's surface, cells; 0 for LOD 0. Of a model: what
                  95 of 100 of these distances do not pass. Of a proxy: what 95 of 100 points of the outer surface of its rocks do
                  not pass */
  uint64_t digest;     /* of the canonical mesh, see docs/pack_format.md */
  const uint8_t* blob; /* inside the pack: Draco bytes, or at the coarsest level a plain mesh */
  size_t blob_size;
} scree_lod;

/* Rocks have the levels 0..lod_count - 1. Proxies are meshes too: see scree_pack_proxy. */
SCREE_API scree_result scree_pack_get_lod(const scree_pack* pack, uint32_t asset, uint32_t lod, scree_lod* out);

/* The coarsest level of a rock or proxy, which needs no decoder: plain vertices and triangles, normals rebuilt as after decoding.
 * vertices, indices: the sizes that scree_lod says (vertices; 3 * triangles), at least. Returns SCREE_OK, CAPACITY,
 * INVALID_ARGUMENT or CORRUPT. Allocates nothing. Thread-safe. */
SCREE_API scree_result scree_pack_coarse_mesh(const scree_pack* pack, uint32_t asset, scree_vertex* vertices,
                                              size_t vertex_capacity, uint16_t* indices, size_t index_capacity);

/* Proxies: the rocks of a whole tile, or of one of the 8 parts that the halves of its axes make, merged into one closed, coarse
 * mesh for the far field. Their assets are numbered after the rocks and have the same calls for levels and decoding; their vertices
 * are in proxy_per_cell lattice steps relative to the centre of the tile's cell (0, 0, 0). code: 0..255. part: 0 = the whole tile,
 * 1 + x + 2 y + 4 z = the part at the low (0) or high (1) half of each axis, where the low half has (N + 1) / 2 cells. Returns the
 * asset, or UINT32_MAX if the arguments are out of range or the pack has no proxies. */
SCREE_API uint32_t scree_pack_proxy(const scree_pack* pack, uint32_t code, uint32_t part);

/* A point that two neighbouring rocks share and erosion spares. */
typedef struct scree_contact {
  int16_t position[3]; /* lattice steps, relative to the centre of the rock's home cell */
  int8_t cell[3];      /* the neighbour's home cell relative to this rock's, each -1..1 */
  uint8_t seed;        /* which rock of that cell */
} scree_contact;

/* Copies the contacts of a rock, ordered by (cell z, y, x, seed).
 * contacts: `capacity` elements, may be NULL when capacity is 0. count: how many there are, always delivered.
 * Returns SCREE_OK, CAPACITY, INVALID_ARGUMENT or CORRUPT. */
SCREE_API scree_result scree_pack_get_contacts(const scree_pack* pack, uint32_t asset, scree_contact* contacts, uint32_t capacity,
                                               uint32_t* count);

/* Copies the vertices of the convex hull, 3 int16 each in lattice steps relative to the home cell's centre: what a physics
 * engine takes as a convex shape. Same rules as above; capacity counts vertices. */
SCREE_API scree_result scree_pack_get_hull(const scree_pack* pack, uint32_t asset, int16_t* xyz, uint32_t capacity,
                                           uint32_t* count);

/* The unique cell that stands in cell (x, y, z), each 0..N-1, of the tile with this code (0..255; bit dx + 2 dy + 4 dz is the
 * colour of corner (dx, dy, dz)), and the rocks of a unique cell: assets first .. first + count - 1. */
SCREE_API scree_result scree_pack_tile_cell(const scree_pack* pack, uint32_t code, uint32_t x, uint32_t y, uint32_t z,
                                            uint32_t* cell);
SCREE_API scree_result scree_pack_cell_assets(const scree_pack* pack, uint32_t cell, uint32_t* first, uint32_t* count);

/* --- models ----------------------------------------------------------------------------------------------------------------- */

/* What models have beside a scree_asset, of cliffs too. Metres at scale 1; the origin is the middle of the ground that the model
 * was made on, the same for all ages of a variant, so that one can take the place of another; y is the height above the ground, and
 * meshes may reach below it. */
typedef struct scree_model {
  uint32_t variant;    /* 0..variant_count - 1 */
  uint32_t age;        /* 0 = youngest */
  float footprint;     /* what stands at the height of the ground stays within this distance of the origin */
  float height;        /* above the ground */
  float share;         /* of the volume of rock at the start that is left, 0..1 */
  uint32_t steps;      /* of weathering since the start; of a cliff, paths of water; of a block, when it fell */
  uint32_t part_count; /* convex parts, 1..255 */
} scree_model;

/* Returns SCREE_OK, INVALID_ARGUMENT (asset out of range, a pack of tiles) or CORRUPT. */
SCREE_API scree_result scree_pack_get_model(const scree_pack* pack, uint32_t asset, scree_model* out);

/* The asset of a variant at an age, of a cliff too. How many ages a variant has: scree_pack_cell_assets. Returns UINT32_MAX if the
 * arguments are out of range or the pack is one of tiles. */
SCREE_API uint32_t scree_pack_model(const scree_pack* pack, uint32_t variant, uint32_t age);

/* Copies the vertices of one convex part of a model, for physics; all parts together cover it better than its one hull does. Same
 * rules as scree_pack_get_hull. part: 0..part_count - 1; 4..64 vertices. */
SCREE_API scree_result scree_pack_get_part(const scree_pack* pack, uint32_t asset, uint32_t part, int16_t* xyz, uint32_t capacity,
                                           uint32_t* count);

/* --- cliffs ----------------------------------------------------------------------------------------------------------------- */

/* A cliff is a pack of models and more. Variant 0 is the cliff; its ages are the times at which it was kept, all with the same
 * origin. Variants 1.. are the blocks that fell, of one age each, positions relative to their centroid. At each time some of the
 * blocks lie about: placements say where. Vertices have UVs, see scree_pack_coarse_uvs; edges of cuts are sharp, because
 * vertices share their normal only where they are at one place and have one smoothing group. */

/* A block that lies somewhere: a place p of its mesh is at translation + p. Blocks are baked turned as they lie, so that no
 * instance has a rotation; one that lies otherwise at a later time is another block. 16 bytes. */
typedef struct scree_block_placement {
  uint32_t asset;       /* of a block */
  float translation[3]; /* metres, relative to the origin of the cliff */
} scree_block_placement;

/* One time. */
typedef struct scree_cliff_time {
  uint32_t asset;           /* of the cliff at this time: scree_pack_model(pack, 0, time) */
  uint32_t paths;           /* of water since the start */
  float share;              /* of the volume of rock at the start that stands, 0..1 */
  uint32_t first_placement; /* in the numbering of all placements */
  uint32_t placement_count; /* of blocks that lie about, ordered so that near ones are mostly near in number */
  float bounds_min[3];      /* that hold the balls of these blocks, metres; 0 where there is none */
  float bounds_max[3];
} scree_cliff_time;

/* time: 0..time_count - 1, in the order of ages. Returns SCREE_OK, INVALID_ARGUMENT (also for a pack of another kind) or CORRUPT.
 * Thread-safe, as the next. */
SCREE_API scree_result scree_pack_get_time(const scree_pack* pack, uint32_t time, scree_cliff_time* out);

/* Copies the placements first .. first + count - 1, of one time or of several: any range, so that they can be read by and by.
 * placements: `count` elements, may be NULL when count is 0. Returns SCREE_OK, INVALID_ARGUMENT (out of range, a pack of another
 * kind) or CORRUPT. */
SCREE_API scree_result scree_pack_get_placements(const scree_pack* pack, uint32_t first, uint32_t count,
                                                 scree_block_placement* placements);

/* UVs of a vertex, for a vertex buffer of unsigned normalised 16-bit numbers: u = uv_min[0] + (uv_max[0] - uv_min[0]) * value /
 * 65535 with the range of scree_pack_info, v likewise. v runs down: 0 is the first row of a picture, as in glTF, Vulkan and
 * Direct3D. */
typedef struct scree_uv {
  uint16_t u, v;
} scree_uv;

/* The UVs of the coarsest level of an asset of a cliff, and the smoothing groups of its vertices, in the order of the vertices of
 * scree_pack_coarse_mesh. Vertices at one place share their normal where their groups are the same.
 * uvs, groups: `capacity` elements, at least as many as scree_lod says; groups may be NULL. Returns SCREE_OK, CAPACITY,
 * INVALID_ARGUMENT (also for a pack of another kind) or CORRUPT. Allocates nothing. Thread-safe. */
SCREE_API scree_result scree_pack_coarse_uvs(const scree_pack* pack, uint32_t asset, scree_uv* uvs, uint8_t* groups,
                                             size_t capacity);

#ifdef __cplusplus
}
#endif

#endif
