/* A scene: camera, light, ground and fields of rock, as plain structs that a program may read, edit and save.
 * The file is JSON, described by content/schema/scene.schema.json; every key of the file is a member here with the same name.
 *
 * Units: metres, +Y up, right-handed; angles in degrees; colours sRGB 0..1, written as "#rrggbb" and so saved in steps of 1/255.
 * Numbers are doubles so that what a person typed is what is saved.
 *
 * Ownership: scene_destroy frees everything below a scene. Strings are arrays of fixed size, so that text fields can edit them. */
#ifndef SCENE_H
#define SCENE_H

#include <scree/cliff.h>
#include <scree/scene.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
  SCENE_NAME_SIZE = 64,        /* bytes of a name with its NUL, UTF-8 */
  SCENE_FILE_SIZE = 512,       /* bytes of a file name with its NUL */
  SCENE_PALETTE_MAX = 8,       /* base colours of one field */
  SCENE_FILTERS_MAX = 16,      /* filters of one field */
  SCENE_MODELS_MAX = 64,       /* model files of one scatter */
  SCENE_WEIGHTS_MAX = 256,     /* weights of one scatter */
  SCENE_FIELDS_MAX = 64,       /* fields of a scene */
  SCENE_NODES_MAX = 4096,      /* nodes of one support tree */
  SCENE_DEPTH_MAX = 64,        /* levels of one support tree */
  SCENE_CROP_MAX = 16384,      /* samples along a side of a height map */
  SCENE_MESH_RESOLUTION = 512, /* finest distance grid of a mesh */
  SCENE_CORNERS_MAX = 1024,    /* points of an extrusion's polygon */
  SCENE_POINTS_MAX = 256       /* points of a tube, balls of blobs */
};

typedef struct scene_camera {
  double eye[3], target[3]; /* metres */
  double fov;               /* vertical, degrees, 1..170 */
} scene_camera;

typedef struct scene_sun {
  double direction[3]; /* from the ground towards the sun, any length > 0 */
  float colour[3];
} scene_sun;

/* Heights from a 16-bit grey PNG: 0 stands for `low`, 65535 for `high`. Centred on x = z = 0; columns run along +x, rows along +z.
 */
typedef struct scene_height_map {
  char file[SCENE_FILE_SIZE];
  double spacing;   /* metres between samples, > 0 */
  double low, high; /* metres, low < high */
  uint32_t crop[4]; /* first column, first row, columns, rows; all zero = the whole picture */
} scene_height_map;

typedef enum scene_ground_kind { SCENE_GROUND_NONE = 0, SCENE_GROUND_PLANE = 1, SCENE_GROUND_TERRAIN = 2 } scene_ground_kind;

typedef struct scene_ground {
  scene_ground_kind kind;
  float colour[3];
  bool sand;            /* "cover": sand, or earth with grass */
  double height;        /* PLANE: y of the plane */
  scene_height_map map; /* TERRAIN */
  double position[3];   /* TERRAIN: where the centre of the map's height 0 lies */
  bool water;           /* TERRAIN: there is water */
  double water_height;  /* y of its surface */
  float water_colour[3];
} scene_ground;

/* The colour of a stone is one of the base colours, darkened by at most `variation`, both chosen by its world hash. */
typedef struct scene_palette {
  float colours[SCENE_PALETTE_MAX][3];
  uint32_t colour_count; /* >= 1 */
  double variation;      /* 0..1 */
} scene_palette;

/* A point of an extrusion (x and z), a tube or blobs (place and radius). */
typedef struct scene_point {
  double place[3];
  double radius;
} scene_point;

/* A closed mesh of a file, or what stands of a cliff's pack at a time. */
typedef struct scene_mesh {
  char file[SCENE_FILE_SIZE]; /* .obj, .off, .glb or .gltf; empty where there is a pack */
  char pack[SCENE_FILE_SIZE]; /* of a cliff; empty where there is a file */
  uint32_t time, lod;         /* of the pack; a level that it does not have is its coarsest */
  uint32_t resolution;        /* 0 or 8..512 */
} scene_mesh;

/* One node of a support tree: a shape with its transform (scale, then rotate, then move) or a group of children. Parameters mean
 * what the same members of scree_shape mean. */
typedef struct scene_node {
  scree_shape_kind kind; /* any but CALLBACK */
  char name[SCENE_NAME_SIZE];
  double position[3]; /* metres */
  double rotation[3]; /* degrees about the fixed x axis, then y, then z */
  double scale;       /* > 0 */
  union {
    struct {
      double radius;
    } sphere;
    struct {
      double half[3], rounding;
    } box;
    struct {
      double a[3], b[3], radius;
    } capsule;
    struct {
      double radius, half_height;
    } cylinder;
    struct {
      double radius, height;
    } cone;
    struct {
      scene_height_map map;
      double above, below;
    } heightfield;
    scene_mesh mesh;
    struct {
      double radii[3];
    } ellipsoid;
    struct {
      double radius, tube_radius;
    } torus;
    struct {
      double low, high; /* low < high */
    } extrusion;
    struct {
      bool closed;
      uint32_t subdivisions; /* 0..32 */
      double half_height;
    } tube;
    struct {
      scree_pattern_kind kind;
      double spacing, radius, amplitude, wavelength;
    } pattern;
    struct {
      double blend; /* SMOOTH_UNION */
    } group;
    struct {
      double amplitude, wavelength;
      uint32_t octaves; /* 1..8 */
      uint32_t seed;
    } noise;
  };
  scene_point* points; /* EXTRUSION, TUBE and BLOBS only, owned, malloc */
  uint32_t point_count;
  struct scene_node** children; /* groups, and the one child of NOISE; owned */
  uint32_t child_count;
} scene_node;

/* How dense a field is from place to place: members mean what those of scree_filter mean. */
typedef struct scene_filter {
  scree_filter_kind kind;
  bool inverted;
  double from, to, fade; /* SLOPE: degrees; ALTITUDE: world y, metres; from <= to, fade >= 0 */
  scene_height_map map;  /* MASK: shares (low 0 and high 1, which the file does not hold); SLOPE: heights */
  double position[3];    /* MASK, SLOPE: where the centre of the map lies; y is not used */
} scene_filter;

/* What a field has that is a scatter of models on its support, the ground: members mean what those of scree_scatter_desc mean. */
typedef struct scene_scatter {
  char (*models)[SCENE_FILE_SIZE]; /* owned, malloc: .glb or .gltf files, one a model; none = the field's pack holds models */
  uint32_t model_count;
  double spacing;   /* metres, > 0 */
  double scale[2];  /* 0 < scale[0] <= scale[1] */
  double max_slope; /* degrees, > 0, <= 80 */
  double* weights;  /* owned, malloc: >= 0, not all 0; none = as many of each */
  uint32_t weight_count;
  bool has_ages;
  scene_filter ages; /* MASK: black = the youngest, white = the oldest */
} scene_scatter;

/* What a field has that is a cliff of a pack, with its origin at the field's `origin`: see scree_cliff_desc. */
typedef struct scene_cliff {
  uint32_t time; /* 0 = the first that the pack keeps */
  uint32_t what; /* SCREE_CLIFF_..., 0 = both */
  double turn;   /* degrees about +Y, -360..360 */
  double scale;  /* > 0 */
} scene_cliff;

/* Fields are layers of a scree_scene in the order of the file: where they overlap, the earlier wins. A field is a mass of rock, or
 * a scatter, which has no cell size, threshold and shell, or a cliff, which has no support, density and filters either. */
typedef struct scene_field {
  bool is_scatter, is_cliff; /* at most one */
  scene_scatter scatter;
  scene_cliff cliff;
  char name[SCENE_NAME_SIZE];
  char pack[SCENE_FILE_SIZE]; /* name of a recipe, or the path of a .scree file; empty where a scatter has models of its own */
  uint64_t seed;              /* 0..2^53, what JSON numbers hold exactly */
  double cell_size;           /* metres, > 0 */
  double origin[3];           /* world position of corner (0, 0, 0), metres */
  double threshold;           /* share of a rock that must lie inside, 0..1 exclusive */
  bool shell;                 /* leave out the rocks deeper below the surface than twice the largest radius */
  int32_t key;                /* of the layer, 0..65535, goes into ids; -1 = the field's index */
  double density;             /* share of its rocks or models that exist, 0..1, > 0 */
  scene_filter* filters;      /* owned, malloc */
  uint32_t filter_count;
  scene_palette palette;
  scene_node* support; /* owned; NULL of cliffs, and otherwise only while a scene is being built */
} scene_field;

typedef struct scene_model {
  char schema[SCENE_FILE_SIZE]; /* "$schema", kept as found; empty = none */
  char name[SCENE_NAME_SIZE];
  scene_camera camera;
  scene_sun sun;
  float sky[3];
  scene_ground ground;
  scene_field* fields; /* owned, malloc */
  uint32_t field_count;
} scene_model;

/* Fills an empty scene with the defaults of the file format. */
void scene_init(scene_model* out);

/* Frees what a scene owns and empties it. */
void scene_destroy(scene_model* scene);

/* Reads a scene. Unknown keys, wrong types and numbers out of range are errors; `error` then holds one line with the file's name
 * and the path of the key. On failure *out is empty. Returns SCREE_OK, IO, SYNTAX, RANGE or OUT_OF_MEMORY. */
scree_result scene_load(const char* file, scene_model* out, scree_error* error);

/* The same from memory: `size` bytes; `file` is only a name for messages. */
scree_result scene_parse(const char* text, size_t size, const char* file, scene_model* out, scree_error* error);

/* Writes a scene as JSON with its keys in a fixed order. Returns NUL-terminated text to be freed with free, or NULL when memory is
 * short. size: bytes without the NUL, may be NULL. Loading the text and writing it again gives the same text. */
char* scene_write(const scene_model* scene, size_t* size);

/* Writes a scene to a file, under a temporary name until it is whole. */
scree_result scene_save(const scene_model* scene, const char* file, scree_error* error);

/* Adds a field with the default values, without a support. NULL when memory is short or there are SCENE_FIELDS_MAX. */
scene_field* scene_add_field(scene_model* scene);
void scene_remove_field(scene_model* scene, uint32_t index);

/* Makes a field a scatter with the default values, or takes the models and weights of one away (sizes 0). False when memory is
 * short: nothing has changed then. */
bool scene_set_models(scene_scatter* scatter, uint32_t count);
bool scene_set_weights(scene_scatter* scatter, uint32_t count);

/* The key of a field's layer. */
uint16_t scene_field_key(const scene_model* scene, uint32_t index);

/* Appends a filter with default values. NULL when memory is short or there are SCENE_FILTERS_MAX. */
scene_filter* scene_add_filter(scene_field* field, scree_filter_kind kind);
void scene_remove_filter(scene_field* field, uint32_t index);

/* A node of this kind with the default parameters (a sphere of radius 1 and the like), or NULL when memory is short. */
scene_node* scene_node_create(scree_shape_kind kind);

/* A deep copy, or NULL when memory is short. */
scene_node* scene_node_copy(const scene_node* node);

/* Frees a node and all below it; NULL is allowed. */
void scene_node_destroy(scene_node* node);

/* Appends a child, which the parent then owns. Returns false when memory is short: the child is still the caller's. */
bool scene_node_add(scene_node* parent, scene_node* child);

/* Takes a child out of its parent: the caller owns it then. */
scene_node* scene_node_detach(scene_node* parent, uint32_t index);

/* Puts a point before the one at `index`, or behind the last. Returns false when memory is short or the kind holds no more. */
bool scene_node_add_point(scene_node* node, uint32_t index, const scene_point* point);
/* Takes a point out. Returns false when the kind needs as many as there are. */
bool scene_node_remove_point(scene_node* node, uint32_t index);

/* How many points a kind has, both 0 for kinds without. */
typedef struct scene_point_limits {
  uint32_t least, most;
} scene_point_limits;
scene_point_limits scene_kind_points(scree_shape_kind kind);

/* Groups have any number of children, at least one. */
static inline bool scene_kind_is_group(scree_shape_kind kind) {
  return kind >= SCREE_SHAPE_UNION && kind <= SCREE_SHAPE_SMOOTH_UNION;
}

/* Groups, and noise with its one child. */
static inline bool scene_kind_has_children(scree_shape_kind kind) {
  return scene_kind_is_group(kind) || kind == SCREE_SHAPE_NOISE;
}

/* The word of the file format for a kind ("smooth_union"), or NULL. */
const char* scene_kind_name(scree_shape_kind kind);
/* The same for a pattern ("lines") and a filter ("slope"). */
const char* scene_pattern_name(scree_pattern_kind kind);
const char* scene_filter_name(scree_filter_kind kind);

/* The unit quaternion (x, y, z, w) of a node's rotation. Uses + - * / only, so that it is the same on every machine. */
void scene_rotation_quaternion(const double degrees[3], double quaternion[4]);

/* The colour of a stone by its world hash, linear RGB 0..1. base: which base colour it comes from (0..colour_count - 1), may be
 * NULL; the colour is that base colour times one factor, 1 - variation .. 1, delivered in *shade when that is not NULL. */
void scene_stone_colour(const scene_palette* palette, uint32_t world_hash, float linear[3], uint32_t* base, float* shade);

/* What chooses the colour of an instance of a scatter: other bits than those its turn and size are taken from. */
uint32_t scene_model_hash(uint32_t random);

/* One sRGB channel 0..1 as linear light. */
float scene_linear_from_srgb(float value);

#ifdef __cplusplus
}
#endif

#endif
