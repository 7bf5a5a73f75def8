/* The renderer of scree-view: stones, ground and terrain under sun and sky, into a framebuffer of its own. The window shows that
 * framebuffer, headless pictures read it back; both get the same pixels.
 *
 * One picture is the mean of a number of samples, each jittered by less than a pixel and with its own pattern of shadow and
 * occlusion taps; a picture that has not changed since the last call goes on gathering samples.
 *
 *   draw lists (render_list) -> shadow cascades -> surfaces (normal, tags, depth) -> occlusion -> light, added up -> resolve
 *
 * Space: metres from the scene's origin in float, +Y up, right-handed. Needs a current OpenGL 3.3 core context on every call; not
 * thread-safe. */
#ifndef RENDER_H
#define RENDER_H

#include <scree/draco.h>

#ifdef __cplusplus
extern "C" {
#endif

#define RENDER_LODS 6
#define RENDER_CASCADES 3
#define RENDER_NOTHING UINT32_MAX

typedef struct render render;

/* What is known of an asset before any of its meshes is decoded. Lengths in cells. */
typedef struct render_asset {
  float centre[3]; /* of a ball that holds it, from the home cell's centre */
  float radius;
  float errors[RENDER_LODS]; /* largest distance to LOD 0's surface, finest first */
  uint32_t vertices[RENDER_LODS];
  uint32_t triangles[RENDER_LODS];
} render_asset;

/* What the vertices of a source say beside place and normal. */
typedef enum render_look {
  RENDER_LOOK_STONE = 0,   /* nothing: rocks of a pack of tiles */
  RENDER_LOOK_HOODOO = 1,  /* bed, colluvium, durability and curvature: a pack of models; cells are metres */
  RENDER_LOOK_PAINTED = 2, /* an sRGB colour in the bytes material, durability and curvature; cells are metres */
  RENDER_LOOK_CLIFF =
      3 /* material, of which 2 is a cut, durability and curvature, lit as stone: a pack of a cliff; cells are metres */
} render_look;

/* Where meshes come from: a pack, or a test's own stones. `decode` may run on several threads at once; `vertices` and `indices`
 * have room for what the asset says. Returns false when the mesh cannot be had; that is remembered and drawn as nothing. */
typedef struct render_source {
  uint32_t asset_count;
  uint32_t lod_count;         /* 1..RENDER_LODS */
  float lattice_per_cell;     /* lattice steps of scree_vertex.position per cell */
  const render_asset* assets; /* asset_count; copied */
  bool (*decode)(void* user, uint32_t asset, uint32_t lod, scree_vertex* vertices, uint16_t* indices);
  void* user; /* must outlive the renderer or render_remove_source */
  render_look look;
} render_source;

/* One stone or model in the world. 40 bytes. */
typedef struct render_stone {
  float position[3]; /* of the home cell's centre; of a model's foot */
  float cell_size;   /* metres; of a model its scale */
  float turn[2];     /* sine and cosine of a turn about +Y; both 0 = none */
  uint32_t hash;     /* wear: strata, lichen, speckles */
  uint32_t asset;    /* of its source */
  uint8_t colour[3]; /* sRGB */
  uint8_t tile;      /* code of its corner cube */
  uint16_t source;   /* as render_add_source gave it */
  uint16_t group;    /* the caller's own */
} render_stone;

typedef enum render_colour { RENDER_COLOUR_STONE = 0, RENDER_COLOUR_LOD = 1, RENDER_COLOUR_TILE = 2 } render_colour;

typedef struct render_segment {
  float from[3], to[3];
  uint8_t colour[4]; /* sRGB and opacity */
} render_segment;

/* One picture. */
typedef struct render_picture {
  uint32_t width, height; /* pixels, 1..16384 */
  float eye[3];
  float forward[3], up[3]; /* unit, at a right angle */
  float field_of_view;     /* vertical, radians */
  uint32_t samples;        /* how many to add in this call, >= 1 */
  uint32_t samples_most;   /* stop gathering at this many; 0 = samples */
  render_colour colour;
  int32_t lod;       /* this level for every stone, or -1 for the level that the picture needs */
  float pixel_error; /* how far a stone's outline may be off, pixels; 0 = 2 */
  bool wireframe;
  bool shadows_off;
  bool draft;                     /* coarser stones and shadows, for pictures that last for a moment */
  float sun[3];                   /* towards the sun, any length > 0 */
  float sun_colour[3];            /* linear, 0..1 */
  float sky[3];                   /* linear, 0..1: the colour low in the sky; the zenith is bluer, the horizon paler */
  float exposure;                 /* 0 = 1 */
  bool ground;                    /* a plane without end */
  float ground_height;            /* metres */
  bool water;                     /* the plane is still water */
  float water_colour[3];          /* linear, 0..1: of what is seen when looking straight down */
  float ground_colour[3];         /* linear, 0..1: the mean colour of plane and terrain */
  bool ground_sand;               /* plane and terrain are of sand, not of earth with grass */
  const render_segment* segments; /* drawn over the picture, dimmed where something hides them */
  uint32_t segment_count;
  uint32_t decode_budget; /* meshes to decode at most in this call, for pictures that must not wait; 0 = all that are missing */
} render_picture;

/* A picture with a sun, a sky and a ground, of one sample, at the levels of detail it needs; size and camera are the caller's. */
void render_picture_init(render_picture* picture);

typedef struct render_stats {
  uint32_t stones;       /* in the scene */
  uint32_t stones_drawn; /* in view, one sample */
  uint32_t draws;        /* of distinct meshes, one sample */
  uint64_t triangles;    /* of one sample, without shadows */
  uint64_t shadow_triangles;
  uint32_t meshes;         /* resident */
  uint64_t mesh_bytes;     /* of the GPU buffers in use */
  uint32_t meshes_decoded; /* in the last call */
  uint32_t meshes_missing; /* wanted and not yet decoded */
  uint32_t samples;        /* gathered so far */
  bool indirect;           /* glMultiDrawElementsIndirect is used */
  uint32_t free_triangles; /* of the free mesh */
  uint64_t free_sent;      /* bytes of it that its last change sent to the GPU */
} render_stats;

typedef struct render_desc {
  bool no_indirect;     /* stay with what OpenGL 3.3 has */
  uint32_t shadow_size; /* texels a side of a cascade; 0 = 2048 */
  scree_jobs jobs;      /* who decodes meshes */
} render_desc;

/* Returns SCREE_OK, UNSUPPORTED (the context is too old or a shader does not compile; `error` says why) or OUT_OF_MEMORY. */
scree_result render_create(const render_desc* desc, render** out, scree_error* error);
void render_destroy(render* r);

/* Returns the number of the source, or RENDER_NOTHING when memory is short. */
uint32_t render_add_source(render* r, const render_source* source);
/* Forgets a source and its meshes; its number may be given out again. Stones that name it must be gone. */
void render_remove_source(render* r, uint32_t source);

/* Copies all stones of the scene. */
scree_result render_set_stones(render* r, const render_stone* stones, uint32_t count);

/* A surface that is no stone, for instance the mountain under a scree slope. positions, normals: 3 * vertex_count; indices: three a
 * triangle, counter-clockwise from outside. A count of 0 takes it away. */
scree_result render_set_terrain(render* r, const float* positions, const float* normals, uint32_t vertex_count,
                                const uint32_t* indices, uint32_t index_count);

/* A vertex of the free mesh. */
typedef struct render_vertex {
  float position[3];  /* metres */
  float normal[3];    /* unit */
  float occlusion;    /* 1 = in the open */
  uint8_t surface[4]; /* HOODOO: material and bed, durability, curvature as in scree_vertex, 0; PAINTED: sRGB, 0 */
} render_vertex;

/* One mesh that may change with every picture, for instance what is being weathered; only what differs from the one before is sent
 * to the GPU. look: HOODOO or PAINTED. colour: sRGB, of HOODOO. A count of 0 takes it away. Returns SCREE_OK, INVALID_ARGUMENT (an
 * index or a look that cannot be) or OUT_OF_MEMORY. */
scree_result render_set_free_mesh(render* r, const render_vertex* vertices, uint32_t vertex_count, const uint32_t* indices,
                                  uint32_t index_count, render_look look, const uint8_t colour[3]);

/* Draws into the renderer's framebuffer. Returns SCREE_OK, INVALID_ARGUMENT or OUT_OF_MEMORY. */
scree_result render_draw(render* r, const render_picture* picture);

/* Copies the picture to the framebuffer that is bound by name `target` (0 = the window), stretched to width x height. */
void render_show(const render* r, uint32_t target, uint32_t width, uint32_t height);

/* Reads the picture: width * height * 3 bytes sRGB, top row first. */
void render_read(const render* r, uint8_t* rgb);

/* What stands at a pixel of the last picture, (0, 0) at the top left: the row of a stone or RENDER_NOTHING, and in `point` the
 * place in the world; false when it is the sky. */
bool render_pick(const render* r, uint32_t x, uint32_t y, uint32_t* stone, float point[3]);

void render_get_stats(const render* r, render_stats* out);

#ifdef __cplusplus
}
#endif

#endif
