/* Is a triangle mesh the border of a solid: every edge used as often in one direction as in the other, and the right side out? More
 * than once each way is where solids touch along an edge: winding numbers, which decide what is inside, are whole there too. */
#include "allocator.h"
#include "edge_table.h"
#include "support_mesh.h"
#include "support_text.h"

static void say_shape(scree_error* error, uint32_t shape_index) {
  scree_rt_text_clear(error);
  scree_rt_text_add(error, "shape ");
  scree_rt_text_add_count(error, shape_index);
  scree_rt_text_add(error, ": mesh");
}

static scree_result refuse_edge(scree_error* error, uint32_t shape_index, uint32_t from, uint32_t to, uint32_t triangle,
                                const char* why) {
  say_shape(error, shape_index);
  scree_rt_text_add(error, " is not closed: the edge from vertex ");
  scree_rt_text_add_count(error, from);
  scree_rt_text_add(error, " to ");
  scree_rt_text_add_count(error, to);
  scree_rt_text_add(error, " of triangle ");
  scree_rt_text_add_count(error, triangle);
  scree_rt_text_add(error, why);
  return SCREE_ERROR_NOT_CLOSED;
}

/* excess: of each place of the table, how many more triangles use the edge from its lower vertex to its higher than back. */
static scree_result check_edges(const scree_shape* shape, uint32_t shape_index, const edge_table* table, int32_t* excess,
                                scree_error* error) {
  for (uint32_t t = 0; t < shape->mesh.triangle_count; ++t) {
    const uint32_t* v = shape->mesh.indices + (size_t)3 * t;
    for (int k = 0; k < 3; ++k) {
      uint32_t from = v[k], to = v[(k + 1) % 3];
      if (from == to) {
        say_shape(error, shape_index);
        scree_rt_text_add(error, " triangle ");
        scree_rt_text_add_count(error, t);
        scree_rt_text_add(error, " uses vertex ");
        scree_rt_text_add_count(error, from);
        scree_rt_text_add(error, " twice");
        return SCREE_ERROR_INVALID_ARGUMENT;
      }
      const uint64_t key = from < to ? edge_key(from, to) : edge_key(to, from);
      uint64_t* place = edge_place(table, key);
      *place = key;
      excess[place - table->edges] += from < to ? 1 : -1;
    }
  }
  for (uint32_t t = 0; t < shape->mesh.triangle_count; ++t) {
    const uint32_t* v = shape->mesh.indices + (size_t)3 * t;
    for (int k = 0; k < 3; ++k) {
      uint32_t from = v[k], to = v[(k + 1) % 3];
      const uint64_t* place = edge_place(table, from < to ? edge_key(from, to) : edge_key(to, from));
      const int32_t more = from < to ? excess[place - table->edges] : -excess[place - table->edges];
      if (more == 1) return refuse_edge(error, shape_index, from, to, t, " has no triangle on its other side");
      if (more > 1) return refuse_edge(error, shape_index, from, to, t, " is used by another triangle in the same direction");
    }
  }
  return SCREE_OK;
}

/* Six times the volume, from the first vertex so that far away meshes keep their digits. */
static double volume6(const scree_shape* shape) {
  const float* origin = shape->mesh.positions;
  double sum = 0;
  for (uint32_t t = 0; t < shape->mesh.triangle_count; ++t) {
    double p[3][3];
    for (int k = 0; k < 3; ++k)
      for (int a = 0; a < 3; ++a)
        p[k][a] = (double)shape->mesh.positions[(size_t)3 * shape->mesh.indices[(size_t)3 * t + k] + a] - (double)origin[a];
    sum += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) + p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
           p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return sum;
}

scree_result scree_rt_support_mesh_check(const scree_shape* shape, uint32_t shape_index, const scree_allocator* allocator,
                                         scree_error* error) {
  edge_table table = {NULL, 16};
  while (table.size < (size_t)6 * shape->mesh.triangle_count) table.size *= 2;
  table.edges = scree_rt_allocate_zeroed(allocator, table.size, sizeof *table.edges);
  int32_t* excess = scree_rt_allocate_zeroed(allocator, table.size, sizeof *excess);
  scree_result result = SCREE_ERROR_OUT_OF_MEMORY;
  if (table.edges != NULL && excess != NULL) result = check_edges(shape, shape_index, &table, excess, error);
  scree_rt_release(allocator, excess, table.size, sizeof *excess);
  scree_rt_release(allocator, table.edges, table.size, sizeof *table.edges);
  if (result != SCREE_OK) return result;

  double volume = volume6(shape);
  if (volume > 0) return SCREE_OK;
  say_shape(error, shape_index);
  scree_rt_text_add(
      error, volume < 0 ? " is inside out: its triangles must run counter-clockwise seen from outside" : " encloses no volume");
  return SCREE_ERROR_INVALID_ARGUMENT;
}
