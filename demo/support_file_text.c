/* Mesh files that are text: Wavefront OBJ and Geomview OFF. Polygons become fans. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "support_file.h"

typedef struct reader {
  const char* at;
  const char* file;
  scree_error* error;
  scree_result result;
  uint32_t line;
  triangle_mesh mesh;
  size_t vertex_room, triangle_room;
  float* coordinates; /* u, v of each vt of an OBJ file, v turned */
  uint32_t coordinate_count;
  size_t coordinate_room, uv_room;
  bool lacks_uvs; /* a triangle has none, so that those of all others are of no use */
} reader;

/* Of a face. Numbers from 0. */
typedef struct corner {
  uint32_t vertex, coordinate; /* coordinate: NO_COORDINATE where it has none */
} corner;

#define NO_COORDINATE UINT32_MAX

static bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}
static bool is_end(char c) {
  return c == '\n' || c == '\0';
}

static void skip_spaces(reader* r) {
  for (;;) {
    while (is_space(*r->at)) ++r->at;
    /* A backslash joins lines in OBJ. */
    const char* next = r->at + 1;
    if (*r->at != '\\') return;
    while (is_space(*next)) ++next;
    if (*next != '\n') return;
    ++r->line;
    r->at = next + 1;
  }
}

static void skip_line(reader* r) {
  while (!is_end(*r->at)) ++r->at;
  if (*r->at == '\n') {
    ++r->at;
    ++r->line;
  }
}

static bool fail(reader* r, const char* what) {
  if (r->result == SCREE_OK) r->result = fail_with(r->error, SCREE_ERROR_SYNTAX, "%s: line %u: %s", r->file, r->line, what);
  return false;
}

static bool fail_memory(reader* r) {
  if (r->result == SCREE_OK) r->result = fail_with(r->error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", r->file);
  return false;
}

static bool read_float(reader* r, float* out) {
  skip_spaces(r);
  if (is_end(*r->at)) return fail(r, "expected a number"); /* strtof would go on in the next line */
  char* end;
  float value = strtof(r->at, &end);
  if (end == r->at || !isfinite(value)) return fail(r, "expected a number");
  if (!is_space(*end) && !is_end(*end) && *end != '#') return fail(r, "expected a number");
  r->at = end;
  *out = value;
  return true;
}

static bool read_integer(reader* r, long long* out) {
  char* end;
  /* strtoll would walk over line breaks to find a number. */
  if (!(*r->at == '-' || *r->at == '+' || (*r->at >= '0' && *r->at <= '9'))) return fail(r, "expected a whole number");
  errno = 0;
  long long value = strtoll(r->at, &end, 10);
  if (end == r->at || errno != 0) return fail(r, "expected a whole number");
  r->at = end;
  *out = value;
  return true;
}

/* `memory` with room for `needed` elements, moved if it must be; NULL when memory is short, and `memory` is then as it was. */
static void* with_room(void* memory, size_t* room, size_t needed, size_t element) {
  if (needed <= *room) return memory;
  size_t wanted = *room * 2 > needed ? *room * 2 : needed + 64;
  if (wanted > SIZE_MAX / element) return NULL;
  void* grown = realloc(memory, wanted * element);
  if (grown != NULL) *room = wanted;
  return grown;
}

static bool add_vertex(reader* r) {
  float p[3];
  for (int i = 0; i < 3; ++i) {
    if (!read_float(r, &p[i])) return false;
  }
  if (r->mesh.vertex_count >= INT32_MAX) return fail(r, "too many vertices");
  float* positions = with_room(r->mesh.positions, &r->vertex_room, (size_t)r->mesh.vertex_count + 1, sizeof p);
  if (positions == NULL) return fail_memory(r);
  r->mesh.positions = positions;
  memcpy(positions + 3 * (size_t)r->mesh.vertex_count++, p, sizeof p);
  return true;
}

/* u, and v where it is there. v runs up in OBJ. */
static bool add_coordinate(reader* r) {
  float uv[2] = {0, 0};
  if (!read_float(r, &uv[0])) return false;
  skip_spaces(r);
  if (!is_end(*r->at) && *r->at != '#' && !read_float(r, &uv[1])) return false;
  uv[1] = 1 - uv[1];
  if (r->coordinate_count >= INT32_MAX) return fail(r, "too many texture coordinates");
  float* coordinates = with_room(r->coordinates, &r->coordinate_room, (size_t)r->coordinate_count + 1, sizeof uv);
  if (coordinates == NULL) return fail_memory(r);
  r->coordinates = coordinates;
  memcpy(coordinates + 2 * (size_t)r->coordinate_count++, uv, sizeof uv);
  return true;
}

/* Of the triangle that is about to be added. */
static bool add_uvs(reader* r, const corner corners[3]) {
  for (int k = 0; k < 3; ++k) r->lacks_uvs = r->lacks_uvs || corners[k].coordinate == NO_COORDINATE;
  if (r->lacks_uvs) return true;
  float* uvs = with_room(r->mesh.uvs, &r->uv_room, (size_t)r->mesh.triangle_count + 1, 6 * sizeof *uvs);
  if (uvs == NULL) return fail_memory(r);
  r->mesh.uvs = uvs;
  for (size_t k = 0; k < 3; ++k)
    memcpy(uvs + 6 * (size_t)r->mesh.triangle_count + 2 * k, r->coordinates + 2 * (size_t)corners[k].coordinate, 2 * sizeof *uvs);
  return true;
}

static bool add_triangle(reader* r, corner a, corner b, corner c) {
  if (r->mesh.triangle_count >= INT32_MAX) return fail(r, "too many triangles");
  uint32_t* indices = with_room(r->mesh.indices, &r->triangle_room, (size_t)r->mesh.triangle_count + 1, 3 * sizeof *indices);
  if (indices == NULL) return fail_memory(r);
  r->mesh.indices = indices;
  const corner corners[3] = {a, b, c};
  if (!add_uvs(r, corners)) return false;
  for (size_t k = 0; k < 3; ++k) indices[3 * (size_t)r->mesh.triangle_count + k] = corners[k].vertex;
  ++r->mesh.triangle_count;
  return true;
}

/* Adds the triangles of a polygon, one corner after the other. */
typedef struct fan {
  corner first, last;
  uint32_t corners;
} fan;

static bool add_corner(reader* r, fan* polygon, corner next) {
  if (polygon->corners == 0) polygon->first = next;
  if (polygon->corners >= 2 && !add_triangle(r, polygon->first, polygon->last, next)) return false;
  polygon->last = next;
  ++polygon->corners;
  return true;
}

static scree_result finish(reader* r, triangle_mesh* out) {
  free(r->coordinates);
  if (r->lacks_uvs) {
    free(r->mesh.uvs);
    r->mesh.uvs = NULL;
  }
  if (r->result == SCREE_OK) {
    *out = r->mesh;
  } else {
    triangle_mesh_free(&r->mesh);
    *out = (triangle_mesh){0};
  }
  return r->result;
}

static reader start(const char* bytes, const char* file, scree_error* error) {
  return (reader){.at = bytes, .file = file, .error = error, .line = 1};
}

/* The number of one of the `count` vertices or texture coordinates before it; negative ones count back from the last. */
static bool obj_index(reader* r, uint32_t count, const char* unknown, uint32_t* out) {
  long long number;
  if (!read_integer(r, &number)) return false;
  if (number < 0) number += (long long)count + 1;
  if (number < 1 || number > (long long)count) return fail(r, unknown);
  *out = (uint32_t)(number - 1);
  return true;
}

/* A corner of an OBJ face: "7", "7/1", "7//2" or "7/1/2". */
static bool obj_corner(reader* r, fan* polygon) {
  corner next = {0, NO_COORDINATE};
  if (!obj_index(r, r->mesh.vertex_count, "a face names a vertex that does not exist", &next.vertex)) return false;
  for (int i = 0; i < 2 && *r->at == '/'; ++i) {
    long long ignored;
    ++r->at;
    if (*r->at == '/' || is_space(*r->at) || is_end(*r->at)) continue;
    if (i == 1 && !read_integer(r, &ignored)) return false;
    if (i == 0 && !obj_index(r, r->coordinate_count, "a face names a vt that does not exist", &next.coordinate)) return false;
  }
  if (!is_space(*r->at) && !is_end(*r->at)) return fail(r, "expected a corner such as 7, 7/1, 7//2 or 7/1/2");
  return add_corner(r, polygon, next);
}

static bool obj_face(reader* r) {
  fan polygon = {0};
  for (;;) {
    skip_spaces(r);
    if (is_end(*r->at) || *r->at == '#') break;
    if (!obj_corner(r, &polygon)) return false;
  }
  return polygon.corners >= 3 || fail(r, "a face has fewer than 3 corners");
}

/* Whether a NUL stands inside the file: text has none, and readers stop there. */
static bool has_nul(const char* bytes, size_t size) {
  return memchr(bytes, '\0', size) != NULL;
}

scree_result mesh_read_obj(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error) {
  reader r = start(bytes, file, error);
  if (has_nul(bytes, size)) fail(&r, "not an OBJ file: it holds a zero byte");
  while (r.result == SCREE_OK && *r.at != '\0') {
    skip_spaces(&r);
    bool word_ends = r.at[0] != '\0' && is_space(r.at[1]);
    if (r.at[0] == 'v' && word_ends) {
      ++r.at;
      add_vertex(&r);
    } else if (r.at[0] == 'v' && r.at[1] == 't' && is_space(r.at[2])) {
      r.at += 2;
      add_coordinate(&r);
    } else if (r.at[0] == 'f' && word_ends) {
      ++r.at;
      obj_face(&r);
    }
    skip_line(&r);
  }
  if (r.result == SCREE_OK && r.mesh.triangle_count == 0)
    r.result = fail_with(error, SCREE_ERROR_SYNTAX, "%s: has no triangles", file);
  return finish(&r, out);
}

/* Goes to the next line of an OFF file that holds something. */
static bool off_next(reader* r) {
  for (;;) {
    while (is_space(*r->at)) ++r->at;
    if (*r->at == '\0') return fail(r, "the file ends early");
    if (*r->at != '\n' && *r->at != '#') return true;
    skip_line(r);
  }
}

static bool off_count(reader* r, uint32_t limit, uint32_t* out) {
  long long number;
  if (!off_next(r) || !read_integer(r, &number)) return false;
  if (number < 0 || number > (long long)limit) return fail(r, "a count or an index out of range");
  *out = (uint32_t)number;
  return true;
}

static bool off_face(reader* r) {
  uint32_t corners;
  fan polygon = {0};
  if (!off_count(r, INT32_MAX, &corners)) return false;
  if (corners < 3) return fail(r, "a face has fewer than 3 corners");
  for (uint32_t i = 0; i < corners; ++i) {
    corner next = {0, NO_COORDINATE};
    if (!off_count(r, r->mesh.vertex_count - 1, &next.vertex) || !add_corner(r, &polygon, next)) return false;
  }
  return true;
}

static bool off_read(reader* r, size_t size) {
  static const char* const headers[] = {"OFF", "COFF", "NOFF", "CNOFF", "STOFF"};
  if (!off_next(r)) return false;
  size_t length = strcspn(r->at, " \t\r\n");
  bool known = false;
  for (size_t i = 0; i < sizeof headers / sizeof headers[0]; ++i)
    known = known || (strlen(headers[i]) == length && memcmp(headers[i], r->at, length) == 0);
  if (!known) return fail(r, "not an OFF file: it does not begin with OFF");
  r->at += length;
  skip_spaces(r);
  if (strncmp(r->at, "BINARY", 6) == 0) return fail(r, "binary OFF is not read, only text");
  uint32_t vertices, faces, edges;
  /* No vertex takes fewer than 6 bytes and no face fewer than 8, so a count that cannot be is refused before memory is taken. */
  if (!off_count(r, (uint32_t)(size / 6), &vertices) || !off_count(r, (uint32_t)(size / 8), &faces) ||
      !off_count(r, INT32_MAX, &edges))
    return false;
  if (vertices == 0 || faces == 0) return fail(r, "has no triangles");
  skip_line(r);
  for (uint32_t i = 0; i < vertices; ++i) {
    if (!off_next(r) || !add_vertex(r)) return false;
    skip_line(r);
  }
  for (uint32_t i = 0; i < faces; ++i) {
    if (!off_face(r)) return false;
    skip_line(r);
  }
  return true;
}

scree_result mesh_read_off(const char* bytes, size_t size, const char* file, triangle_mesh* out, scree_error* error) {
  reader r = start(bytes, file, error);
  if (has_nul(bytes, size)) {
    fail(&r, "not a text OFF file: it holds a zero byte");
  } else {
    off_read(&r, size);
  }
  return finish(&r, out);
}
