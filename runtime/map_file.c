#define _POSIX_C_SOURCE 200809L
#include "map_file.h"

#include <fcntl.h>
#include <stdint.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

bool scree_rt_map_file(const char* path, mapped_file* out) {
  *out = (mapped_file){NULL, 0};
  /* Without O_NONBLOCK, opening a pipe nobody writes to would wait for ever. */
  int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return false;
  struct stat status;
  bool mapped = fstat(file, &status) == 0 && S_ISREG(status.st_mode) && (uintmax_t)status.st_size <= SIZE_MAX;
  if (mapped && status.st_size > 0) {
    out->bytes = mmap(NULL, (size_t)status.st_size, PROT_READ, MAP_PRIVATE, file, 0);
    out->size = (size_t)status.st_size;
    mapped = out->bytes != MAP_FAILED;
  }
  close(file); /* the mapping stays */
  if (!mapped) *out = (mapped_file){NULL, 0};
  return mapped;
}

void scree_rt_unmap_file(mapped_file* file) {
  if (file->bytes != NULL) munmap((void*)(uintptr_t)file->bytes, file->size);
  *file = (mapped_file){NULL, 0};
}
