/* A whole file as read-only memory. map_file.c is the POSIX version; another system needs only another such file. */
#ifndef SCREE_MAP_FILE_H
#define SCREE_MAP_FILE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct mapped_file {
  const void* bytes; /* page-aligned; NULL for an empty file */
  size_t size;
} mapped_file;

/* Returns false when the path is not a regular file that can be read and mapped; *out is then empty. */
bool scree_rt_map_file(const char* path, mapped_file* out);

/* An empty mapped_file is allowed. */
void scree_rt_unmap_file(mapped_file* file);

#endif
