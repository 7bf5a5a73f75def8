/* A .glb file, streamed. The layout is that of the glTF 2.0 specification, section 4 (binary glTF). */
#include "glb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buffer.h"
#include "file.h"

#define CHUNK_JSON UINT32_C(0x4e4f534a)
#define CHUNK_BIN UINT32_C(0x004e4942)

enum { TYPE_UNSIGNED_BYTE = 5121, TYPE_UNSIGNED_SHORT = 5123, TYPE_UNSIGNED_INT = 5125, TYPE_FLOAT = 5126 };
enum { TARGET_VERTICES = 34962, TARGET_INDICES = 34963 };

/* What the elements of a stream are. */
static const struct {
  uint32_t size, component;
  const char* type;
  bool normalized, is_attribute;
  uint32_t target;
} formats[GLB_STREAMS] = {
    [GLB_POSITIONS] = {12, TYPE_FLOAT, "VEC3", false, true, TARGET_VERTICES},
    [GLB_NORMALS] = {12, TYPE_FLOAT, "VEC3", false, true, TARGET_VERTICES},
    [GLB_COLOURS] = {4, TYPE_UNSIGNED_BYTE, "VEC4", true, true, TARGET_VERTICES},
    [GLB_INDICES16] = {2, TYPE_UNSIGNED_SHORT, "SCALAR", false, false, TARGET_INDICES},
    [GLB_INDICES32] = {4, TYPE_UNSIGNED_INT, "SCALAR", false, false, TARGET_INDICES},
    [GLB_TRANSLATIONS] = {12, TYPE_FLOAT, "VEC3", false, false, 0},
    [GLB_INSTANCE_COLOURS] = {12, TYPE_FLOAT, "VEC3", false, false, 0},
    [GLB_ROTATIONS] = {16, TYPE_FLOAT, "VEC4", false, false, 0},
    [GLB_SCALES] = {12, TYPE_FLOAT, "VEC3", false, false, 0},
    [GLB_UVS] = {8, TYPE_FLOAT, "VEC2", false, true, TARGET_VERTICES},
    [GLB_BLOBS] = {1, TYPE_UNSIGNED_BYTE, "SCALAR", false, false, 0},
};

typedef struct scratch {
  FILE* file;    /* NULL until something is written */
  uint64_t size; /* bytes */
} scratch;

/* A view of a stream while its place in the file is not known yet: everything but its offset is. */
typedef struct pending_view {
  glb_stream stream;
  uint64_t offset, size; /* in the stream; a whole stream is 0 and its final size */
} pending_view;

struct glb_writer {
  char* path;
  scratch streams[GLB_STREAMS];
  uint32_t stream_views[GLB_STREAMS];
  pending_view* views;
  uint32_t view_count, view_room;
  text_buffer accessors, materials, meshes, nodes, roots;
  uint32_t accessor_count, material_count, mesh_count, node_count;
  bool has_draco, has_instances;
  scree_result result;
  scree_error error;
};

static void fail(glb_writer* w, scree_result result, const char* what) {
  if (w->result == SCREE_OK) w->result = fail_with(&w->error, result, "%s: %s", w->path, what);
}

scree_result glb_begin(const char* path, glb_writer** out, scree_error* error) {
  *out = NULL;
  glb_writer* w = calloc(1, sizeof *w);
  char* copy = malloc(strlen(path) + 1);
  if (w == NULL || copy == NULL) {
    free(w);
    free(copy);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
  }
  strcpy(copy, path);
  w->path = copy;
  /* A place that cannot be written to is better known now than after all the work. */
  scree_result result = file_replace_check(path, error);
  if (result != SCREE_OK) {
    free(copy);
    free(w);
    return result;
  }
  for (int i = 0; i < GLB_STREAMS; ++i) w->stream_views[i] = GLB_NONE;
  *out = w;
  return SCREE_OK;
}

void glb_abort(glb_writer* w) {
  if (w == NULL) return;
  for (int i = 0; i < GLB_STREAMS; ++i) {
    if (w->streams[i].file != NULL) fclose(w->streams[i].file);
  }
  text_buffer* texts[] = {&w->accessors, &w->materials, &w->meshes, &w->nodes, &w->roots};
  for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) buffer_free(texts[i]);
  free(w->views);
  free(w->path);
  free(w);
}

static uint32_t add_view(glb_writer* w, glb_stream stream, uint64_t offset, uint64_t size) {
  if (w->view_count == w->view_room) {
    uint32_t room = w->view_room * 2 + 64;
    pending_view* grown = realloc(w->views, room * sizeof *grown);
    if (grown == NULL) {
      fail(w, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
      return 0;
    }
    w->views = grown;
    w->view_room = room;
  }
  w->views[w->view_count] = (pending_view){stream, offset, size};
  return w->view_count++;
}

/* Appends bytes and returns where they begin in the stream. */
static uint64_t append(glb_writer* w, glb_stream stream, const void* data, size_t size) {
  scratch* s = &w->streams[stream];
  if (w->result != SCREE_OK) return 0;
  if (s->file == NULL) {
    w->result = file_scratch(w->path, &s->file, &w->error);
    if (w->result != SCREE_OK) return 0;
  }
  uint64_t offset = s->size;
  if (fwrite(data, 1, size, s->file) != size) fail(w, SCREE_ERROR_IO, "cannot write its scratch file; is the disk full?");
  s->size += size;
  return offset;
}

/* The separator of a new element of a JSON array. */
static void next_item(text_buffer* text, uint32_t* count) {
  buffer_add(text, *count > 0 ? ",\n" : "\n");
  ++*count;
}

static void add_numbers(text_buffer* text, const char* key, const float* values) {
  buffer_format(text, ",\"%s\":[", key);
  for (int i = 0; i < 3; ++i) {
    if (i > 0) buffer_add(text, ",");
    buffer_float(text, values[i]);
  }
  buffer_add(text, "]");
}

static uint32_t add_accessor(glb_writer* w, glb_stream stream, uint32_t view, uint64_t offset, uint32_t count, const float* min,
                             const float* max) {
  text_buffer* t = &w->accessors;
  next_item(t, &w->accessor_count);
  buffer_add(t, "{");
  if (view != GLB_NONE) {
    buffer_format(t, "\"bufferView\":%u,", view);
    if (offset > 0) buffer_format(t, "\"byteOffset\":%llu,", (unsigned long long)offset);
  }
  buffer_format(t, "\"componentType\":%u,\"count\":%u,\"type\":\"%s\"", formats[stream].component, count, formats[stream].type);
  if (formats[stream].normalized) buffer_add(t, ",\"normalized\":true");
  if (min != NULL) add_numbers(t, "min", min);
  if (max != NULL) add_numbers(t, "max", max);
  buffer_add(t, "}");
  return w->accessor_count - 1;
}

uint32_t glb_add_data(glb_writer* w, glb_stream stream, const void* data, uint32_t count, const float* min, const float* max) {
  uint64_t offset = append(w, stream, data, (size_t)count * formats[stream].size);
  if (w->stream_views[stream] == GLB_NONE) w->stream_views[stream] = add_view(w, stream, 0, UINT64_MAX);
  return add_accessor(w, stream, w->stream_views[stream], offset, count, min, max);
}

uint32_t glb_add_accessor(glb_writer* w, glb_stream stream, uint32_t count, const float* min, const float* max) {
  return add_accessor(w, stream, GLB_NONE, 0, count, min, max);
}

uint32_t glb_add_blob(glb_writer* w, const void* data, size_t size) {
  static const char zeros[4] = {0};
  uint64_t offset = append(w, GLB_BLOBS, data, size);
  append(w, GLB_BLOBS, zeros, (4 - size % 4) % 4);
  return add_view(w, GLB_BLOBS, offset, size);
}

uint32_t glb_add_material(glb_writer* w, const char* name, const float colour[3]) {
  text_buffer* t = &w->materials;
  next_item(t, &w->material_count);
  buffer_add(t, "{\"name\":");
  buffer_string(t, name);
  buffer_add(t, ",\"pbrMetallicRoughness\":{\"baseColorFactor\":[");
  for (int i = 0; i < 3; ++i) {
    buffer_float(t, colour[i]);
    buffer_add(t, ",");
  }
  buffer_add(t, "1],\"metallicFactor\":0,\"roughnessFactor\":0.95}}");
  return w->material_count - 1;
}

static void add_primitive(glb_writer* w, const glb_mesh* mesh) {
  text_buffer* t = &w->meshes;
  bool has_colours = mesh->colours != GLB_NONE, has_uvs = mesh->uvs != GLB_NONE;
  buffer_format(t, "{\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u", mesh->positions, mesh->normals);
  if (has_colours) buffer_format(t, ",\"COLOR_0\":%u", mesh->colours);
  if (has_uvs) buffer_format(t, ",\"TEXCOORD_0\":%u", mesh->uvs);
  buffer_format(t, "},\"indices\":%u", mesh->indices);
  if (mesh->material != GLB_NONE) buffer_format(t, ",\"material\":%u", mesh->material);
  if (mesh->blob != GLB_NONE) {
    w->has_draco = true;
    buffer_format(
        t, ",\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":%u,\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u",
        mesh->blob, mesh->position_id, mesh->normal_id);
    if (has_colours) buffer_format(t, ",\"COLOR_0\":%u", mesh->colour_id);
    if (has_uvs) buffer_format(t, ",\"TEXCOORD_0\":%u", mesh->uv_id);
    buffer_add(t, "}}}");
  }
  buffer_add(t, "}");
}

uint32_t glb_add_mesh(glb_writer* w, const glb_mesh* mesh) {
  text_buffer* t = &w->meshes;
  next_item(t, &w->mesh_count);
  buffer_add(t, "{");
  if (mesh->name != NULL) {
    buffer_add(t, "\"name\":");
    buffer_string(t, mesh->name);
    buffer_add(t, ",");
  }
  buffer_add(t, "\"primitives\":[");
  for (const glb_mesh* part = mesh; part != NULL; part = part->also) {
    if (part != mesh) buffer_add(t, ",");
    add_primitive(w, part);
  }
  buffer_add(t, "]}");
  return w->mesh_count - 1;
}

/* Adds a key of an object that may be its first. */
static void node_key(text_buffer* t, bool* first, const char* key) {
  buffer_format(t, "%s\"%s\":", *first ? "" : ",", key);
  *first = false;
}

uint32_t glb_add_node(glb_writer* w, const glb_node* node) {
  text_buffer* t = &w->nodes;
  uint32_t row = w->node_count;
  bool first = true;
  next_item(t, &w->node_count);
  buffer_add(t, "{");
  if (node->name != NULL && node->name[0] != '\0') {
    node_key(t, &first, "name");
    buffer_string(t, node->name);
  }
  if (node->mesh != GLB_NONE) {
    node_key(t, &first, "mesh");
    buffer_format(t, "%u", node->mesh);
  }
  if (node->translation[0] != 0 || node->translation[1] != 0 || node->translation[2] != 0) {
    node_key(t, &first, "translation");
    for (int i = 0; i < 3; ++i) {
      buffer_add(t, i > 0 ? "," : "[");
      buffer_number(t, node->translation[i]);
    }
    buffer_add(t, "]");
  }
  if (node->rotation[1] != 0 || node->rotation[3] != 0 || node->rotation[0] != 0 || node->rotation[2] != 0) {
    node_key(t, &first, "rotation");
    for (int i = 0; i < 4; ++i) {
      buffer_add(t, i > 0 ? "," : "[");
      buffer_number(t, node->rotation[i]);
    }
    buffer_add(t, "]");
  }
  if (node->scale != 0 && node->scale != 1) {
    node_key(t, &first, "scale");
    for (int i = 0; i < 3; ++i) {
      buffer_add(t, i > 0 ? "," : "[");
      buffer_number(t, node->scale);
    }
    buffer_add(t, "]");
  }
  if (node->translations != GLB_NONE) {
    w->has_instances = true;
    node_key(t, &first, "extensions");
    buffer_format(t, "{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":%u", node->translations);
    if (node->rotations != GLB_NONE) buffer_format(t, ",\"ROTATION\":%u", node->rotations);
    if (node->scales != GLB_NONE) buffer_format(t, ",\"SCALE\":%u", node->scales);
    if (node->instance_colours != GLB_NONE) buffer_format(t, ",\"_COLOR_0\":%u", node->instance_colours);
    buffer_add(t, "}}}");
  }
  if (node->child_count > 0) {
    node_key(t, &first, "children");
    for (uint32_t i = 0; i < node->child_count; ++i) buffer_format(t, "%c%u", i > 0 ? ',' : '[', node->first_child + i);
    buffer_add(t, "]");
  }
  buffer_add(t, "}");
  if (node->is_root) buffer_format(&w->roots, "%s%u", w->roots.length > 0 ? "," : "", row);
  return row;
}

uint32_t glb_node_count(const glb_writer* w) {
  return w->node_count;
}

static void add_array(text_buffer* json, const char* name, text_buffer* items, uint32_t count) {
  if (count == 0) return;
  buffer_format(json, ",\n\"%s\":[", name);
  if (items->failed) json->failed = true;
  buffer_add_bytes(json, items->bytes != NULL ? items->bytes : "", items->length);
  buffer_add(json, "\n]");
  buffer_free(items);
}

static void add_extensions(text_buffer* json, const glb_writer* w) {
  static const char* const keys[] = {"extensionsUsed", "extensionsRequired"};
  if (!w->has_draco && !w->has_instances) return;
  for (int i = 0; i < 2; ++i) {
    buffer_format(json, ",\n\"%s\":[", keys[i]);
    if (w->has_draco) buffer_add(json, "\"KHR_draco_mesh_compression\"");
    if (w->has_draco && w->has_instances) buffer_add(json, ",");
    if (w->has_instances) buffer_add(json, "\"EXT_mesh_gpu_instancing\"");
    buffer_add(json, "]");
  }
}

static uint64_t padded(uint64_t size) {
  return (size + 3) & ~UINT64_C(3);
}

static void add_views(text_buffer* json, const glb_writer* w, const uint64_t* starts) {
  buffer_add(json, ",\n\"bufferViews\":[");
  for (uint32_t i = 0; i < w->view_count; ++i) {
    const pending_view* v = &w->views[i];
    uint64_t size = v->size == UINT64_MAX ? w->streams[v->stream].size : v->size;
    buffer_format(json, "%s\n{\"buffer\":0,\"byteOffset\":%llu,\"byteLength\":%llu", i > 0 ? "," : "",
                  (unsigned long long)(starts[v->stream] + v->offset), (unsigned long long)size);
    /* Several accessors read one view, and then vertex attributes must name their stride. */
    if (formats[v->stream].is_attribute) buffer_format(json, ",\"byteStride\":%u", formats[v->stream].size);
    if (formats[v->stream].target != 0) buffer_format(json, ",\"target\":%u", formats[v->stream].target);
    buffer_add(json, "}");
  }
  buffer_add(json, "\n]");
}

static void put_word(FILE* stream, uint64_t word) {
  for (int i = 0; i < 4; ++i) putc((int)(word >> (8 * i) & 255), stream);
}

/* Copies a scratch file to the end of `to` and pads it to 4 bytes. */
static bool copy_stream(const scratch* s, FILE* to) {
  enum { BLOCK = 1 << 14 };
  char block[BLOCK];
  bool good = s->file == NULL || (fflush(s->file) == 0 && fseek(s->file, 0, SEEK_SET) == 0);
  uint64_t left = s->size;
  while (good && left > 0) {
    size_t part = left < BLOCK ? (size_t)left : BLOCK;
    good = fread(block, 1, part, s->file) == part && fwrite(block, 1, part, to) == part;
    left -= part;
  }
  for (uint64_t i = s->size; i < padded(s->size); ++i) putc(0, to);
  return good;
}

static void write_file(glb_writer* w, text_buffer* json, uint64_t bin, uint64_t* bytes) {
  while (json->length % 4 != 0) buffer_add(json, " ");
  uint64_t total = 12 + 8 + (uint64_t)json->length + (bin > 0 ? 8 + bin : 0);
  if (total > UINT32_MAX) {
    fail(w, SCREE_ERROR_RANGE, "more than 4 GiB, which a .glb cannot hold: choose a coarser level of detail, or fewer rocks");
    return;
  }
  file_replacement file;
  w->result = file_replace_begin(w->path, &file, &w->error);
  if (w->result != SCREE_OK) return;
  fwrite("glTF", 1, 4, file.stream);
  put_word(file.stream, 2);
  put_word(file.stream, total);
  put_word(file.stream, json->length);
  put_word(file.stream, CHUNK_JSON);
  fwrite(json->bytes, 1, json->length, file.stream);
  bool good = true;
  if (bin > 0) {
    put_word(file.stream, bin);
    put_word(file.stream, CHUNK_BIN);
    for (int i = 0; i < GLB_STREAMS; ++i) good = good && copy_stream(&w->streams[i], file.stream);
  }
  if (good) {
    w->result = file_replace_commit(&file, &w->error);
  } else {
    file_replace_abort(&file);
    fail(w, SCREE_ERROR_IO, "cannot write; is the disk full?");
  }
  *bytes = total;
}

scree_result glb_finish(glb_writer* w, uint64_t* bytes, scree_error* error) {
  uint64_t starts[GLB_STREAMS], bin = 0, total = 0;
  for (int i = 0; i < GLB_STREAMS; ++i) {
    starts[i] = bin;
    bin += padded(w->streams[i].size);
  }
  text_buffer json = {0};
  buffer_format(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"scree %s\"}", scree_version_string());
  add_extensions(&json, w);
  buffer_add(&json, ",\n\"scene\":0,\n\"scenes\":[{");
  if (w->roots.failed) json.failed = true;
  if (w->roots.length > 0) {
    buffer_add(&json, "\"nodes\":[");
    buffer_add_bytes(&json, w->roots.bytes, w->roots.length);
    buffer_add(&json, "]");
  }
  buffer_add(&json, "}]");
  add_array(&json, "nodes", &w->nodes, w->node_count);
  add_array(&json, "meshes", &w->meshes, w->mesh_count);
  add_array(&json, "materials", &w->materials, w->material_count);
  add_array(&json, "accessors", &w->accessors, w->accessor_count);
  if (w->view_count > 0) add_views(&json, w, starts);
  if (bin > 0) buffer_format(&json, ",\n\"buffers\":[{\"byteLength\":%llu}]", (unsigned long long)bin);
  buffer_add(&json, "}\n");
  if (json.failed) fail(w, SCREE_ERROR_OUT_OF_MEMORY, "out of memory");
  if (w->result == SCREE_OK) write_file(w, &json, bin, &total);
  buffer_free(&json);
  scree_result result = w->result;
  if (result != SCREE_OK && error != NULL) *error = w->error;
  if (bytes != NULL) *bytes = total;
  glb_abort(w);
  return result;
}
