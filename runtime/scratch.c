/* Scratch memory of queries. */
#include "scratch.h"

#include <string.h>

#include "allocator.h"

scree_result scree_scratch_create(const scree_allocator* given, scree_scratch** out) {
  if (out == NULL) return SCREE_ERROR_INVALID_ARGUMENT;
  scree_allocator allocator = scree_rt_allocator_or_default(given);
  *out = scree_rt_allocate_zeroed(&allocator, 1, sizeof **out);
  if (*out == NULL) return SCREE_ERROR_OUT_OF_MEMORY;
  (*out)->allocator = allocator;
  return SCREE_OK;
}

void scree_scratch_destroy(scree_scratch* scratch) {
  if (scratch == NULL) return;
  scree_allocator allocator = scratch->allocator;
  for (int i = 0; i < SCRATCH_USES; ++i) scree_rt_release(&allocator, scratch->buffers[i].memory, scratch->buffers[i].size, 1);
  scree_rt_release(&allocator, scratch, 1, sizeof *scratch);
}

/* A quarter more than was asked for, so that questions that grow bit by bit do not allocate each time. */
static size_t roomy(size_t count, size_t size) {
  if (size != 0 && count > SIZE_MAX / 2 / size) return 0;
  size_t bytes = count * size;
  return (bytes + bytes / 4 + 4095) / 4096 * 4096;
}

void* scree_rt_scratch_extend(scree_scratch* scratch, scratch_use use, size_t kept, size_t count, size_t size) {
  scratch_buffer* buffer = &scratch->buffers[use];
  if (buffer->memory != NULL && count <= buffer->size / size) return buffer->memory;
  size_t bytes = roomy(count, size);
  void* memory = bytes > 0 ? scree_rt_allocate(&scratch->allocator, bytes, 1) : NULL;
  if (memory == NULL) return NULL;
  if (kept > 0) memcpy(memory, buffer->memory, kept * size);
  scree_rt_release(&scratch->allocator, buffer->memory, buffer->size, 1);
  *buffer = (scratch_buffer){memory, bytes};
  return memory;
}

void* scree_rt_scratch_reserve(scree_scratch* scratch, scratch_use use, size_t count, size_t size) {
  scratch_buffer* buffer = &scratch->buffers[use];
  if (buffer->memory != NULL && count <= buffer->size / size) return buffer->memory;
  scree_rt_release(&scratch->allocator, buffer->memory, buffer->size, 1); /* first, so that both are never held at once */
  *buffer = (scratch_buffer){NULL, 0};
  return scree_rt_scratch_extend(scratch, use, 0, count, size);
}
