#include "support_mesh.h"

#include "allocator.h"

scree_result support_mesh_check(const scree_shape* shape, uint32_t shape_index, const scree_allocator* allocator,
                                scree_error* error) {
  (void)shape;
  (void)shape_index;
  (void)allocator;
  (void)error;
  return SCREE_ERROR_UNSUPPORTED;
}
scree_result support_mesh_create(support_mesh* grid, const scree_shape* shape, const scree_jobs* jobs,
                                 const scree_allocator* allocator) {
  (void)grid;
  (void)shape;
  (void)jobs;
  (void)allocator;
  return SCREE_ERROR_UNSUPPORTED;
}
void support_mesh_destroy(support_mesh* grid, const scree_allocator* allocator) {
  release(allocator, grid->samples, (size_t)grid->size[0] * grid->size[1] * grid->size[2], sizeof(float));
}
