#include "render_solid.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "render_meshes.h"

void render_solid_create(render_solid* s) {
  memset(s, 0, sizeof *s);
  glGenVertexArrays(1, &s->vertex_array);
  glGenBuffers(1, &s->vertex_buffer);
  glGenBuffers(1, &s->index_buffer);
  glBindVertexArray(s->vertex_array);
  glBindBuffer(GL_ARRAY_BUFFER, s->vertex_buffer);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, s->index_buffer);
  glEnableVertexAttribArray(0);
  glEnableVertexAttribArray(1);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), (const void*)0);
  glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), buffer_offset(3 * sizeof(float)));
  glBindVertexArray(0);
}

void render_solid_destroy(render_solid* s) {
  glDeleteVertexArrays(1, &s->vertex_array);
  glDeleteBuffers(1, &s->vertex_buffer);
  glDeleteBuffers(1, &s->index_buffer);
}

scree_result render_solid_fill(render_solid* s, const float* positions, const float* normals, uint32_t vertex_count,
                               const uint32_t* indices, uint32_t index_count) {
  s->index_count = 0;
  if (vertex_count == 0 || index_count == 0) return SCREE_OK;
  float* vertices = malloc((size_t)vertex_count * 6 * sizeof *vertices);
  if (vertices == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  for (int a = 0; a < 3; ++a) {
    s->min[a] = INFINITY;
    s->max[a] = -INFINITY;
  }
  for (uint32_t i = 0; i < vertex_count; ++i)
    for (int a = 0; a < 3; ++a) {
      vertices[6 * i + a] = positions[3 * i + a];
      vertices[6 * i + 3 + a] = normals[3 * i + a];
      s->min[a] = fminf(s->min[a], positions[3 * i + a]);
      s->max[a] = fmaxf(s->max[a], positions[3 * i + a]);
    }
  while (glGetError() != GL_NO_ERROR) continue;
  glBindVertexArray(0);
  glBindBuffer(GL_ARRAY_BUFFER, s->vertex_buffer);
  glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(vertex_count * 6 * sizeof *vertices), vertices, GL_STATIC_DRAW);
  glBindBuffer(GL_COPY_WRITE_BUFFER, s->index_buffer);
  glBufferData(GL_COPY_WRITE_BUFFER, (GLsizeiptr)(index_count * sizeof *indices), indices, GL_STATIC_DRAW);
  free(vertices);
  if (glGetError() != GL_NO_ERROR) return SCREE_ERROR_OUT_OF_MEMORY;
  s->index_count = index_count;
  return SCREE_OK;
}

scree_result render_solid_disc(render_solid* s, const float eye[3], float height, float radius) {
  enum { SPOKES = 64, RINGS = 12 };
  float positions[3 * (SPOKES * RINGS + 1)], normals[3 * (SPOKES * RINGS + 1)];
  uint32_t indices[SPOKES * 3 + SPOKES * (RINGS - 1) * 6], count = 0;
  for (int ring = 0; ring < RINGS; ++ring) {
    float far = radius * powf(0.35f, (float)(RINGS - 1 - ring));
    for (int spoke = 0; spoke < SPOKES; ++spoke) {
      float angle = (float)spoke * (6.2831853f / SPOKES);
      float* p = positions + 3 * (1 + ring * SPOKES + spoke);
      p[0] = eye[0] + far * cosf(angle);
      p[1] = height;
      p[2] = eye[2] + far * sinf(angle);
      uint32_t here = (uint32_t)(1 + ring * SPOKES + spoke), next = (uint32_t)(1 + ring * SPOKES + (spoke + 1) % SPOKES);
      if (ring == 0) {
        const uint32_t triangle[3] = {0, next, here};
        memcpy(indices + count, triangle, sizeof triangle);
        count += 3;
      } else {
        const uint32_t quad[6] = {here, here - SPOKES, next, next, here - SPOKES, next - SPOKES};
        memcpy(indices + count, quad, sizeof quad);
        count += 6;
      }
    }
  }
  positions[0] = eye[0];
  positions[1] = height;
  positions[2] = eye[2];
  for (int i = 0; i <= SPOKES * RINGS; ++i) {
    normals[3 * i] = normals[3 * i + 2] = 0;
    normals[3 * i + 1] = 1;
  }
  return render_solid_fill(s, positions, normals, SPOKES * RINGS + 1, indices, count);
}

void render_solid_draw(const render_solid* s) {
  if (s->index_count == 0) return;
  glBindVertexArray(s->vertex_array);
  glDrawElements(GL_TRIANGLES, (GLsizei)s->index_count, GL_UNSIGNED_INT, NULL);
  glBindVertexArray(0);
}
