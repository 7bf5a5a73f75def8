/* The layout of a pack, format version 4. docs/pack_format.md says the same in words; the two change together.
 *
 *   0            64                    aligned to 64        aligned to 64
 *   | pack_header | pack_section [n]   | section 0 | 0..0 | section 1 | 0..0 | ... | section n-1 |
 *                                                                                                file_size
 * Everything is little-endian. All structs are laid out without padding, so that the mapped bytes are used as they are.
 * What depends on the Draco encoder (blobs and their index) has sections of its own, so that the digests of the others, and with
 * them the digest of the pack, are the same whatever encoder wrote the blobs. */
#ifndef SCREE_PACK_FORMAT_H
#define SCREE_PACK_FORMAT_H

#include <scree/pack.h>

#if defined(__BYTE_ORDER__) && __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "packs are used in place and are little-endian; a big-endian reader would have to convert every section on opening"
#endif

#define PACK_FORMAT_VERSION 4u
#define PACK_ALIGNMENT 64u

/* In the manner of PNG: a byte with its top bit set catches seven-bit transfers, CR LF and LF catch changed line ends, ^Z stops
 * a listing on old consoles. */
#define PACK_MAGIC "\x89SCR\r\n\x1a\n"
#define PACK_MAGIC_SIZE 8u

/* Kinds are never renumbered. A reader skips kinds it does not know. */
enum {
  PACK_RECIPE = 1,      /* JSON text and one NUL */
  PACK_TILES = 2,       /* u32 unique cell [256][N][N][N], x fastest; empty in packs of models */
  PACK_CELLS = 3,       /* u32 first asset [cells + 1]; cells are unique cells, or variants of models */
  PACK_ASSETS = 4,      /* pack_asset [assets], by (cell, seed) */
  PACK_LODS = 5,        /* pack_lod [assets + proxies][lods] */
  PACK_CONTACTS = 6,    /* pack_contact or pack_narrow_contact */
  PACK_HULLS = 7,       /* i16 [3] or i8 [3], lattice steps: of all assets, and behind them of all parts of models */
  PACK_BLOB_INDEX = 8,  /* pack_blob [assets + proxies][lods] */
  PACK_BLOBS = 9,       /* Draco bytes, or at the coarsest level a plain mesh, each blob 4-byte aligned */
  PACK_PARTS = 10,      /* u32 first hull vertex [parts + 1]; packs of models and cliffs only, as the next */
  PACK_MODELS = 11,     /* pack_model [assets] */
  PACK_PLACEMENTS = 12, /* pack_placement, those of one time behind those of the time before; cliffs only, as the next */
  PACK_TIMES = 13,      /* pack_time [ages of variant 0] */
  PACK_UVS = 14,        /* pack_uvs, one */
  PACK_SECTION_KINDS = 14,
  PACK_TILE_KINDS = 9,     /* packs of tiles have kinds 1..9 */
  PACK_MODEL_KINDS = 11,   /* packs of models have kinds 1..11 */
  PACK_CANONICAL_KINDS = 7 /* kinds 1..7 do not depend on the encoder, nor do 10 and above */
};

enum {
  PACK_MAX_SECTIONS = 64,
  PACK_MAX_CELLS_PER_CUBE = 16,
  PACK_MAX_TILE_REACH = 16,         /* radii, errors and centroids of rocks and proxies, cells */
  PACK_MAX_MODEL_REACH = 4096,      /* the same of models, and coordinates of placements, metres */
  PACK_MAX_UV = 65536,              /* coordinates of the range of UVs */
  PACK_MAX_LATTICE_PER_CELL = 4096, /* so that a rock, which stays within 1.5 cells of its centre, fits int16 */
  PACK_MAX_LODS = 8,
  PACK_PROXY_PARTS = 9,                  /* of a tile: the whole, and the halves of its axes */
  PACK_PROXIES = 256 * PACK_PROXY_PARTS, /* of a pack that has any */
  PACK_MAX_BURIAL = 7,                   /* SCREE_BURIAL_NEVER */
  PACK_MAX_ROCKS_PER_CELL = 255,
  PACK_MAX_HULL = 64,
  PACK_MIN_HULL = 4,
  PACK_MAX_PARTS = 255,
  PACK_MAX_MODEL_VERTICES = 1 << 16, /* of a level, so that its indices fit 16 bits */
  PACK_NEIGHBOURS = 27,
  PACK_BLOB_UNIT = 4,
  /* No blob of Draco packs triangles this tightly. The bound keeps a damaged count from asking the host for gigabytes. */
  PACK_MAX_TRIANGLES_PER_BLOB_BYTE = 16
};

typedef struct pack_header {
  uint8_t magic[PACK_MAGIC_SIZE];
  uint32_t format_version;
  uint32_t section_count;
  uint64_t file_size;
  uint64_t table_digest;  /* XXH3-64 of the section table */
  uint64_t pack_digest;   /* see scree_rt_pack_digest() */
  uint8_t cells_per_cube; /* 0 in packs of models */
  uint8_t kind;           /* scree_pack_kind */
  uint16_t reserved;      /* 0 */
  uint16_t lattice_per_cell;
  uint16_t proxy_per_cell; /* 0 where there are no proxies */
  uint32_t lod_count;
  uint32_t max_rocks_per_cell;
  float max_radius;      /* cells */
  uint32_t header_check; /* low half of XXH3-64 of the 60 bytes before it */
} pack_header;

typedef struct pack_section {
  uint32_t kind;
  uint32_t element_size; /* bytes */
  uint64_t offset;       /* from the start of the file, a multiple of 64 */
  uint64_t size;         /* bytes, a multiple of element_size */
  uint64_t digest;       /* XXH3-64 of the section's bytes */
} pack_section;

typedef struct pack_asset {
  uint32_t cell;
  uint32_t first_contact;
  uint32_t first_hull; /* in vertices */
  uint8_t contact_count;
  uint8_t burial; /* 1..PACK_MAX_BURIAL */
  uint8_t hull_count;
  uint8_t seed;
  int16_t bounds_min[3], bounds_max[3]; /* lattice steps */
  float centroid[3];                    /* cells, as all below */
  float volume;
  float inner_radius;
  float outer_radius;
} pack_asset;

typedef struct pack_lod {
  uint64_t digest; /* of the mesh, see mesh_digest.h */
  uint32_t triangles;
  float error; /* cells */
} pack_lod;

typedef struct pack_contact {
  int16_t position[3]; /* lattice steps */
  uint8_t neighbour;   /* (x + 1) + 3 (y + 1) + 9 (z + 1) of the neighbour's home cell */
  uint8_t seed;
} pack_contact;

/* Where all coordinates of all contacts fit into a byte, as they do on the usual lattices. */
typedef struct pack_narrow_contact {
  int8_t position[3];
  uint8_t neighbour;
  uint8_t seed;
} pack_narrow_contact;

typedef struct pack_blob {
  uint32_t offset;   /* in units of 4 bytes, from the start of the blobs: sections up to 16 GiB */
  uint32_t size;     /* bytes */
  uint32_t vertices; /* as decoded: Draco gives every fan of triangles around a pinched vertex a vertex of its own */
} pack_blob;

/* What only models have. Metres. */
typedef struct pack_model {
  float footprint;
  float height;
  float share;
  uint32_t steps;
  uint32_t first_part;
  uint32_t part_count;
} pack_model;

/* Where a block lies. */
typedef struct pack_placement {
  uint32_t asset;
  float translation[3]; /* metres */
} pack_placement;

typedef struct pack_time {
  uint32_t first_placement, placement_count;
  float bounds_min[3], bounds_max[3]; /* of the balls of the blocks, metres; 0 where there is none */
} pack_time;

/* What the values 0 and 65535 of all UVs stand for. */
typedef struct pack_uvs {
  float min[2], max[2];
} pack_uvs;

#define PACK_STATIC_ASSERT(name, condition) typedef char pack_assert_##name[(condition) ? 1 : -1]
PACK_STATIC_ASSERT(header, sizeof(pack_header) == 64);
PACK_STATIC_ASSERT(section, sizeof(pack_section) == 32);
PACK_STATIC_ASSERT(asset, sizeof(pack_asset) == 52);
PACK_STATIC_ASSERT(lod, sizeof(pack_lod) == 16);
PACK_STATIC_ASSERT(contact, sizeof(pack_contact) == 8);
PACK_STATIC_ASSERT(narrow_contact, sizeof(pack_narrow_contact) == 5);
PACK_STATIC_ASSERT(blob, sizeof(pack_blob) == 12);
PACK_STATIC_ASSERT(model, sizeof(pack_model) == 24);
PACK_STATIC_ASSERT(placement, sizeof(pack_placement) == 16);
PACK_STATIC_ASSERT(time, sizeof(pack_time) == 32);
PACK_STATIC_ASSERT(uvs, sizeof(pack_uvs) == 16);

/* How many kinds a pack has: those from 1 up to this. */
uint32_t scree_rt_pack_kinds(const pack_header* header);

/* Bytes of one element of a kind, 0 for an unknown kind. narrow: of contacts and hulls with coordinates of one byte. */
uint32_t scree_rt_pack_element_size(uint32_t kind, bool narrow);

/* XXH3-64 of `size` bytes, seed 0. */
uint64_t scree_rt_pack_bytes_digest(const void* bytes, size_t size);

/* What header_check must be. */
uint32_t scree_rt_pack_header_check(const pack_header* header);

/* Where a placement stands in the order of its time: the Morton code of its translation on a grid of 1/128 m from -4096 m on, x in
 * bit 0. translation: each coordinate within -4096..4096. */
uint64_t scree_rt_pack_place_code(const float translation[3]);

/* What pack_digest must be: XXH3-64 of the five numbers at bytes 40..59 of the header followed by the digests of the sections of
 * kinds 1..7 in that order, and of kinds 10 and above that packs of this kind have. sections[kind - 1] is the entry of each kind.
 */
uint64_t scree_rt_pack_digest(const pack_header* header, const pack_section* sections[PACK_SECTION_KINDS]);

/* Whether a number is at most a limit away from 0; false for NaN too. */
static inline bool within(float value, float limit) {
  return value >= -limit && value <= limit;
}

#endif
