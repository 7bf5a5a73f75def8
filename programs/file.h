/* Files of the programs: read a whole one, replace one so that nobody ever sees half of it. What differs between systems is here.
 */
#ifndef FILE_H
#define FILE_H

#include <scree/base.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Reads a whole regular file. bytes: malloc'ed, with a NUL after the last byte, to be freed with free. A file larger than `limit`
 * is an error. Returns SCREE_OK, IO, RANGE (too large) or OUT_OF_MEMORY, with a line that names the file. */
scree_result file_read(const char* path, size_t limit, char** bytes, size_t* size, scree_error* error);

bool file_exists(const char* path);

/* A file that is being written under a temporary name beside its final one. */
typedef struct file_replacement {
  FILE* stream;
  char* path;
  char* temporary; /* NULL when `path` is no regular file (a device, a pipe, a link) and is written directly */
} file_replacement;

scree_result file_replace_begin(const char* path, file_replacement* out, scree_error* error);

/* Whether what lies at `path` would be replaced: false for a device, a pipe or a link, which are written directly. */
bool file_is_replaced(const char* path);

/* Flushes and renames. On failure the temporary file is gone and what lay at `path` before is untouched. */
scree_result file_replace_commit(file_replacement* file, scree_error* error);

/* Whether file_replace_begin would succeed: to be asked before long work, so that a wrong path is told at once. Leaves nothing
 * behind and does not open a pipe or a device. Returns SCREE_OK, IO or OUT_OF_MEMORY. */
scree_result file_replace_check(const char* path, scree_error* error);

/* Gives up: removes the temporary file. Harmless after commit and on a zeroed struct. */
void file_replace_abort(file_replacement* file);

/* A nameless scratch file in the same folder as `path`, gone when it is closed. Returns SCREE_OK, IO or OUT_OF_MEMORY. */
scree_result file_scratch(const char* path, FILE** out, scree_error* error);

/* Joins the folder of `base` (what stands before its last slash) and `name`; an absolute name stays as it is. Returns false when
 * the result does not fit into `capacity` bytes. */
bool file_beside(const char* base, const char* name, char* out, size_t capacity);

/* Writes one formatted line into `error` (may be NULL); control characters become '?', so that it stays one line. Returns `result`.
 */
#ifdef __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
scree_result
fail_with(scree_error* error, scree_result result, const char* format, ...);

#ifdef __cplusplus
}
#endif

#endif
