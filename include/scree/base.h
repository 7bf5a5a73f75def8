/* scree: result codes, allocator, jobs and the version. Every other header of scree includes this one.
 *
 * Units of the whole API: metres, +Y up, right-handed (glTF's space). Lengths inside a pack are in cells or in lattice
 * steps, and the comment of each field says so. */
#ifndef SCREE_BASE_H
#define SCREE_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The one place that holds the version; the build reads it from here. */
#define SCREE_VERSION_MAJOR 0
#define SCREE_VERSION_MINOR 1
#define SCREE_VERSION_PATCH 0

#if defined(SCREE_SHARED) && defined(_WIN32)
#ifdef SCREE_BUILDING
#define SCREE_API __declspec(dllexport)
#else
#define SCREE_API __declspec(dllimport)
#endif
#elif defined(__GNUC__)
#define SCREE_API __attribute__((visibility("default")))
#else
#define SCREE_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* What a call that can fail returns. Codes are never renumbered. */
typedef enum scree_result {
  SCREE_OK = 0,
  SCREE_ERROR_INVALID_ARGUMENT = 1, /* the caller's mistake, found where a check is cheap */
  SCREE_ERROR_OUT_OF_MEMORY = 2,
  SCREE_ERROR_IO = 3,          /* a file could not be opened, read or mapped */
  SCREE_ERROR_NOT_A_PACK = 4,  /* the first bytes are not a pack's */
  SCREE_ERROR_VERSION = 5,     /* a pack of another format version */
  SCREE_ERROR_TRUNCATED = 6,   /* the bytes end before what the header promises */
  SCREE_ERROR_CORRUPT = 7,     /* an offset, count or value that cannot be */
  SCREE_ERROR_DIGEST = 8,      /* the bytes are not the ones that were baked */
  SCREE_ERROR_UNSUPPORTED = 9, /* this build lacks the part that was asked for */
  SCREE_ERROR_CAPACITY = 10,   /* the caller's buffer is too small; the needed size was delivered */
  SCREE_ERROR_NOT_CLOSED = 11, /* a triangle mesh with a border or a flipped triangle; where it is said, with an edge of several */
  SCREE_ERROR_SYNTAX = 12,     /* text that is not the JSON that was expected */
  SCREE_ERROR_RANGE = 13,      /* a number outside its documented range */
  SCREE_ERROR_CANCELLED = 14,  /* the progress callback asked to stop */
  SCREE_ERROR_PACK_KIND = 15   /* a pack of another kind than the one that is needed: tiles, models or a cliff */
} scree_result;

/* The code's name and meaning as one short English phrase, static storage. Any value is accepted. Thread-safe. */
SCREE_API const char* scree_result_string(scree_result result);

/* "MAJOR.MINOR.PATCH" of the library that was linked, static storage. Thread-safe. */
SCREE_API const char* scree_version_string(void);

/* Where memory comes from. All zero means malloc and free. `alloc` returns memory aligned to at least 64 bytes or NULL;
 * `release` gets the size that was asked for. Both are called from whichever thread runs a call, and from the workers of
 * scree_jobs, so they must be thread-safe when jobs are given. */
typedef struct scree_allocator {
  void* (*alloc)(void* user, size_t size);
  void (*release)(void* user, void* memory, size_t size);
  void* user;
} scree_allocator;

/* Who runs work in parallel. All zero means the calling thread does all of it. `parallel_for` calls run(context, index,
 * worker) once for every index in [0, count), in any order, with worker in [0, worker_count) unique among those that run
 * at the same time, and returns when all are done. Results never depend on the order or on worker_count. */
typedef struct scree_jobs {
  void (*parallel_for)(void* user, uint32_t count, void (*run)(void* context, uint32_t index, uint32_t worker), void* context);
  uint32_t worker_count; /* >= 1 when parallel_for is given */
  void* user;
} scree_jobs;

/* Who runs work in the background. All zero means none: such work is then done inside the call that asks for it. `submit` takes
 * run(context), to be called once, later, on any thread; it must not block and may call run at once. `help` is called while the
 * library has to wait for submitted work: it runs some of that work, or yields the processor. Everything submitted must have been
 * run before the object that submitted it can be destroyed; destroy calls `help` until that is so. */
typedef struct scree_tasks {
  void (*submit)(void* user, void (*run)(void* context), void* context);
  void (*help)(void* user); /* NULL: spin */
  void* user;
} scree_tasks;

/* How bad it is. */
typedef enum scree_log_level { SCREE_LOG_ERROR = 0, SCREE_LOG_WARNING = 1, SCREE_LOG_INFO = 2 } scree_log_level;

/* Who hears what the library has to say. All zero means nobody. `message` is one line, NUL-terminated, gone after the call. May be
 * called from any thread that runs a call or a task. */
typedef struct scree_log {
  void (*write)(void* user, scree_log_level level, const char* message);
  void* user;
} scree_log;

/* One line of text about what went wrong, for people: names the key, the value and what was expected. */
typedef struct scree_error {
  char message[512]; /* NUL-terminated, no line break */
} scree_error;

#ifdef __cplusplus
}
#endif

#endif
