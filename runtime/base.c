/* Result codes as text, the version, and the default allocator. */
#include "allocator.h"

#include <stdlib.h>
#include <string.h>

#define TEXT(x) #x
#define TEXT_OF(x) TEXT(x)
#define VERSION_STRING(major, minor, patch) TEXT_OF(major) "." TEXT_OF(minor) "." TEXT_OF(patch)

const char* scree_version_string(void) {
  return VERSION_STRING(SCREE_VERSION_MAJOR, SCREE_VERSION_MINOR, SCREE_VERSION_PATCH);
}

const char* scree_result_string(scree_result result) {
  switch (result) {
    case SCREE_OK: return "success";
    case SCREE_ERROR_INVALID_ARGUMENT: return "invalid argument";
    case SCREE_ERROR_OUT_OF_MEMORY: return "out of memory";
    case SCREE_ERROR_IO: return "file cannot be read or written";
    case SCREE_ERROR_NOT_A_PACK: return "not a scree pack";
    case SCREE_ERROR_VERSION: return "pack has another format version";
    case SCREE_ERROR_TRUNCATED: return "file is truncated";
    case SCREE_ERROR_CORRUPT: return "file is corrupt";
    case SCREE_ERROR_DIGEST: return "digest does not match";
    case SCREE_ERROR_UNSUPPORTED: return "not supported by this build";
    case SCREE_ERROR_CAPACITY: return "buffer is too small";
    case SCREE_ERROR_NOT_CLOSED: return "mesh is not closed";
    case SCREE_ERROR_SYNTAX: return "syntax error";
    case SCREE_ERROR_RANGE: return "number out of range";
    case SCREE_ERROR_CANCELLED: return "cancelled";
    case SCREE_ERROR_PACK_KIND: return "pack is of the wrong kind: tiles, models and a cliff are not alike";
  }
  return "unknown result code";
}

static void* malloc_aligned(void* user, size_t size) {
  (void)user;
  size_t rounded = (size + SCREE_ALIGNMENT - 1) / SCREE_ALIGNMENT * SCREE_ALIGNMENT;
  if (rounded < size) return NULL;
  return aligned_alloc(SCREE_ALIGNMENT, rounded > 0 ? rounded : SCREE_ALIGNMENT);
}

static void free_aligned(void* user, void* memory, size_t size) {
  (void)user;
  (void)size;
  free(memory);
}

scree_allocator scree_rt_allocator_or_default(const scree_allocator* given) {
  if (given != NULL && given->alloc != NULL) return *given;
  return (scree_allocator){malloc_aligned, free_aligned, NULL};
}

void* scree_rt_allocate(const scree_allocator* allocator, size_t count, size_t size) {
  if (size != 0 && count > SIZE_MAX / size) return NULL;
  return allocator->alloc(allocator->user, count * size);
}

void* scree_rt_allocate_zeroed(const scree_allocator* allocator, size_t count, size_t size) {
  void* memory = scree_rt_allocate(allocator, count, size);
  if (memory != NULL) memset(memory, 0, count * size);
  return memory;
}

void scree_rt_release(const scree_allocator* allocator, void* memory, size_t count, size_t size) {
  if (memory != NULL) allocator->release(allocator->user, memory, count * size);
}
