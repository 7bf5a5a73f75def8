#include "render_free.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render_meshes.h"

enum { PIECE = 16384 }; /* bytes that are compared and sent at once */

void render_free_create(render_free* f) {
  memset(f, 0, sizeof *f);
  glGenVertexArrays(1, &f->vertex_array);
  glGenBuffers(1, &f->vertex_buffer);
  glGenBuffers(1, &f->index_buffer);
  glBindVertexArray(f->vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, f->vertex_buffer);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, f->index_buffer);
  static const GLuint attributes[] = {0, 1, 2, 6, 7, 8};
  for (size_t i = 0; i < sizeof attributes / sizeof *attributes; ++i) glEnableVertexAttribArray(attributes[i]);
  const GLsizei stride = sizeof(render_vertex);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(render_vertex, position)));
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(render_vertex, normal)));
  glVertexAttribPointer(2, 1, GL_FLOAT, GL_FALSE, stride, buffer_offset(offsetof(render_vertex, occlusion)));
  for (GLuint i = 0; i < 3; ++i)
    glVertexAttribIPointer(6 + i, 1, i < 2 ? GL_UNSIGNED_BYTE : GL_BYTE, stride,
                           buffer_offset(offsetof(render_vertex, surface) + i));
  glBindVertexArray(0);
}

void render_free_destroy(render_free* f) {
  glDeleteVertexArrays(1, &f->vertex_array);
  glDeleteBuffers(1, &f->vertex_buffer);
  glDeleteBuffers(1, &f->index_buffer);
  free(f->vertices);
  free(f->indices);
  memset(f, 0, sizeof *f);
}

/* Sends what differs from `held`, which holds the first `held_size` bytes of the buffer, and makes `held` the same. The buffer is
 * bound to GL_COPY_WRITE_BUFFER. */
static uint64_t send(void* held, size_t held_size, const void* data, size_t size) {
  uint64_t sent = 0;
  for (size_t at = 0; at < size;) {
    size_t end = at;
    while (end < size) {
      const size_t piece = size - end < PIECE ? size - end : PIECE;
      if (end + piece <= held_size && memcmp((const char*)held + end, (const char*)data + end, piece) == 0) break;
      end += piece;
    }
    if (end > at) {
      glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)at, (GLsizeiptr)(end - at), (const char*)data + at);
      memcpy((char*)held + at, (const char*)data + at, end - at);
      sent += end - at;
    }
    at = end < size ? end + (size - end < PIECE ? size - end : PIECE) : end; /* the piece after a run is the same */
  }
  return sent;
}

/* Brings one buffer and its copy up to date. Returns false when memory is short. */
static bool update(uint32_t buffer, void** held, uint32_t* room, uint32_t held_count, const void* data, uint32_t count,
                   size_t element, uint64_t* sent) {
  glBindBuffer(GL_COPY_WRITE_BUFFER, buffer);
  size_t held_size = held_count * element;
  if (count > *room) {
    const uint64_t wanted = (uint64_t)count + count / 4 + 1024;
    void* grown = wanted * element <= INTPTR_MAX && wanted <= UINT32_MAX ? realloc(*held, (size_t)wanted * element) : NULL;
    if (grown == NULL) return false;
    *held = grown;
    while (glGetError() != GL_NO_ERROR) continue;
    glBufferData(GL_COPY_WRITE_BUFFER, (GLsizeiptr)(wanted * element), NULL, GL_DYNAMIC_DRAW);
    *room = 0;
    if (glGetError() != GL_NO_ERROR) return false;
    *room = (uint32_t)wanted;
    held_size = 0;
  }
  *sent += send(*held, held_size, data, count * element);
  return true;
}

scree_result render_free_fill(render_free* f, const render_vertex* vertices, uint32_t vertex_count, const uint32_t* indices,
                              uint32_t index_count) {
  f->sent = 0;
  if (vertex_count == 0 || index_count == 0) {
    f->index_count = 0;
    return SCREE_OK;
  }
  for (uint32_t i = 0; i < index_count; ++i)
    if (indices[i] >= vertex_count) return SCREE_ERROR_INVALID_ARGUMENT;
  void *held_vertices = f->vertices, *held_indices = f->indices;
  glBindVertexArray(0);
  const bool good =
      update(f->vertex_buffer, &held_vertices, &f->vertex_room, f->vertex_count, vertices, vertex_count, sizeof *vertices,
             &f->sent) &&
      update(f->index_buffer, &held_indices, &f->index_room, f->index_count, indices, index_count, sizeof *indices, &f->sent);
  f->vertices = held_vertices;
  f->indices = held_indices;
  f->vertex_count = good ? vertex_count : 0;
  f->index_count = good ? index_count : 0;
  if (!good) return SCREE_ERROR_OUT_OF_MEMORY;
  for (int a = 0; a < 3; ++a) {
    f->min[a] = INFINITY;
    f->max[a] = -INFINITY;
  }
  for (uint32_t i = 0; i < vertex_count; ++i)
    for (int a = 0; a < 3; ++a) {
      f->min[a] = fminf(f->min[a], vertices[i].position[a]);
      f->max[a] = fmaxf(f->max[a], vertices[i].position[a]);
    }
  return SCREE_OK;
}

void render_free_draw(const render_free* f, uint32_t tags) {
  if (f->index_count == 0) return;
  glBindVertexArray(f->vertex_array);
  glVertexAttrib4f(3, 0, 0, 0, 1); /* neither moved nor scaled nor turned */
  glVertexAttribI4ui(4, 0, tags, 0, f->colour[0] | (uint32_t)f->colour[1] << 8 | (uint32_t)f->colour[2] << 16);
  glVertexAttrib2f(5, 0, 1);
  glDrawElements(GL_TRIANGLES, (GLsizei)f->index_count, GL_UNSIGNED_INT, NULL);
  glBindVertexArray(0);
}
