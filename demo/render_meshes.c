#include "render_meshes.h"

#include <epoxy/gl.h>
#include <stdlib.h>
#include <string.h>

#include "render_list.h"

void render_meshes_point_at(uint32_t instance_buffer, uint32_t first) {
  const size_t start = (size_t)first * sizeof(render_instance);
  glBindBuffer(GL_ARRAY_BUFFER, instance_buffer);
  glVertexAttribPointer(3, 4, GL_FLOAT, GL_FALSE, sizeof(render_instance), buffer_offset(start + offsetof(render_instance, place)));
  glVertexAttribIPointer(4, 4, GL_UNSIGNED_INT, sizeof(render_instance), buffer_offset(start + offsetof(render_instance, tags)));
  glVertexAttribPointer(5, 2, GL_FLOAT, GL_FALSE, sizeof(render_instance), buffer_offset(start + offsetof(render_instance, turn)));
}

static void point_at_vertices(const render_meshes* m) {
  glBindVertexArray(m->vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, m->vertex_buffer);
  glVertexAttribPointer(0, 3, GL_SHORT, GL_FALSE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, position)));
  glVertexAttribPointer(1, 3, GL_SHORT, GL_TRUE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, normal)));
  glVertexAttribPointer(2, 1, GL_UNSIGNED_BYTE, GL_TRUE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, occlusion)));
  glVertexAttribIPointer(6, 1, GL_UNSIGNED_BYTE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, material)));
  glVertexAttribIPointer(7, 1, GL_UNSIGNED_BYTE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, durability)));
  glVertexAttribIPointer(8, 1, GL_BYTE, sizeof(scree_vertex), buffer_offset(offsetof(scree_vertex, curvature)));
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, m->index_buffer);
  glBindVertexArray(0);
}

void render_meshes_create(render_meshes* m, uint32_t instance_buffer) {
  memset(m, 0, sizeof *m);
  glGenVertexArrays(1, &m->vertex_array);
  glGenBuffers(1, &m->vertex_buffer);
  glGenBuffers(1, &m->index_buffer);
  point_at_vertices(m);
  glBindVertexArray(m->vertex_array);
  for (GLuint attribute = 0; attribute < 9; ++attribute) glEnableVertexAttribArray(attribute);
  render_meshes_point_at(instance_buffer, 0);
  glVertexAttribDivisor(3, 1);
  glVertexAttribDivisor(4, 1);
  glVertexAttribDivisor(5, 1);
  glBindVertexArray(0);
}

void render_meshes_destroy(render_meshes* m) {
  glDeleteVertexArrays(1, &m->vertex_array);
  glDeleteBuffers(1, &m->vertex_buffer);
  glDeleteBuffers(1, &m->index_buffer);
  free(m->meshes);
  memset(m, 0, sizeof *m);
}

/* Makes room for `needed` elements; keeps the first `used`. Returns false when the driver has no memory. */
static bool grow(uint32_t* buffer, uint32_t* capacity, uint32_t used, uint64_t needed, size_t element) {
  if (needed <= *capacity) return true;
  uint64_t wanted = *capacity < 1024 ? 1024 : *capacity;
  while (wanted < needed) wanted += wanted / 2;
  if (wanted > UINT32_MAX / 2) return false;
  while (glGetError() != GL_NO_ERROR) continue;
  GLuint bigger = 0;
  glGenBuffers(1, &bigger);
  glBindBuffer(GL_COPY_WRITE_BUFFER, bigger);
  glBufferData(GL_COPY_WRITE_BUFFER, (GLsizeiptr)(wanted * element), NULL, GL_STATIC_DRAW);
  if (glGetError() != GL_NO_ERROR) {
    glDeleteBuffers(1, &bigger);
    return false;
  }
  if (used > 0) {
    glBindBuffer(GL_COPY_READ_BUFFER, *buffer);
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0, (GLsizeiptr)(used * element));
  }
  glDeleteBuffers(1, buffer);
  *buffer = bigger;
  *capacity = (uint32_t)wanted;
  return true;
}

uint32_t render_meshes_add(render_meshes* m, const scree_vertex* vertices, uint32_t vertex_count, const uint16_t* indices,
                           uint32_t index_count) {
  if (m->mesh_count == m->mesh_capacity) {
    uint32_t capacity = m->mesh_capacity < 256 ? 256 : m->mesh_capacity * 2;
    render_mesh* meshes = realloc(m->meshes, capacity * sizeof *meshes);
    if (meshes == NULL) return UINT32_MAX;
    m->meshes = meshes;
    m->mesh_capacity = capacity;
  }
  const uint32_t old_vertex_buffer = m->vertex_buffer, old_index_buffer = m->index_buffer;
  bool room = grow(&m->vertex_buffer, &m->vertex_capacity, m->vertex_count, (uint64_t)m->vertex_count + vertex_count,
                   sizeof(scree_vertex)) &&
              grow(&m->index_buffer, &m->index_capacity, m->index_count, (uint64_t)m->index_count + index_count, sizeof(uint16_t));
  if (m->vertex_buffer != old_vertex_buffer || m->index_buffer != old_index_buffer) point_at_vertices(m);
  if (!room) return UINT32_MAX;

  glBindBuffer(GL_COPY_WRITE_BUFFER, m->vertex_buffer);
  glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)(m->vertex_count * sizeof *vertices),
                  (GLsizeiptr)(vertex_count * sizeof *vertices), vertices);
  glBindBuffer(GL_COPY_WRITE_BUFFER, m->index_buffer);
  glBufferSubData(GL_COPY_WRITE_BUFFER, (GLintptr)(m->index_count * sizeof *indices), (GLsizeiptr)(index_count * sizeof *indices),
                  indices);
  m->meshes[m->mesh_count] = (render_mesh){m->index_count, index_count, m->vertex_count, vertex_count};
  m->vertex_count += vertex_count;
  m->index_count += index_count;
  return m->mesh_count++;
}

void render_meshes_clear(render_meshes* m) {
  m->vertex_count = m->index_count = m->mesh_count = 0;
}
