/* Files of the programs, on POSIX. */
#define _POSIX_C_SOURCE 200809L

#include "file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

scree_result fail_with(scree_error* error, scree_result result, const char* format, ...) {
  if (error == NULL) return result;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(error->message, sizeof error->message, format, arguments);
  va_end(arguments);
  for (char* c = error->message; *c != '\0'; ++c) {
    if ((unsigned char)*c < 0x20 || *c == 0x7f) *c = '?';
  }
  return result;
}

scree_result file_read(const char* path, size_t limit, char** bytes, size_t* size, scree_error* error) {
  *bytes = NULL;
  *size = 0;
  FILE* stream = fopen(path, "rb");
  if (stream == NULL) return fail_with(error, SCREE_ERROR_IO, "%s: cannot open: %s", path, strerror(errno));
  struct stat status;
  if (fstat(fileno(stream), &status) != 0 || !S_ISREG(status.st_mode)) {
    fclose(stream);
    return fail_with(error, SCREE_ERROR_IO, "%s: not a regular file", path);
  }
  if ((uintmax_t)status.st_size > limit) {
    fclose(stream);
    return fail_with(error, SCREE_ERROR_RANGE, "%s: %ju bytes, more than the %zu that are read", path, (uintmax_t)status.st_size,
                     limit);
  }
  size_t length = (size_t)status.st_size;
  char* buffer = malloc(length + 1);
  if (buffer == NULL) {
    fclose(stream);
    return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory for %zu bytes", path, length);
  }
  size_t got = fread(buffer, 1, length, stream);
  bool broken = ferror(stream) != 0 || got != length;
  fclose(stream);
  if (broken) {
    free(buffer);
    return fail_with(error, SCREE_ERROR_IO, "%s: read error", path);
  }
  buffer[length] = '\0';
  *bytes = buffer;
  *size = length;
  return SCREE_OK;
}

bool file_exists(const char* path) {
  struct stat status;
  return stat(path, &status) == 0;
}

static char* join(const char* a, const char* b) {
  size_t a_length = strlen(a), b_length = strlen(b);
  char* text = malloc(a_length + b_length + 1);
  if (text == NULL) return NULL;
  memcpy(text, a, a_length);
  memcpy(text + a_length, b, b_length + 1);
  return text;
}

/* mkstemp makes files that only the owner may read; a result gets the rights that fopen would have given it. */
static void give_usual_rights(int descriptor) {
  mode_t mask = umask(0);
  umask(mask);
  (void)!fchmod(descriptor, 0666 & ~mask);
}

static scree_result out_of_memory(const char* path, scree_error* error) {
  return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "%s: out of memory", path);
}

/* Links stay what they are: /dev/stdout is one, also where it leads to a regular file. */
bool file_is_replaced(const char* path) {
  struct stat status;
  return lstat(path, &status) != 0 || S_ISREG(status.st_mode);
}

scree_result file_replace_begin(const char* path, file_replacement* out, scree_error* error) {
  *out = (file_replacement){0};
  struct stat status;
  bool special = !file_is_replaced(path);
  if (special && stat(path, &status) == 0 && S_ISDIR(status.st_mode))
    return fail_with(error, SCREE_ERROR_IO, "%s: is a directory", path);
  out->path = join(path, "");
  if (out->path == NULL) return out_of_memory(path, error);
  if (special) {
    out->stream = fopen(path, "wb");
  } else {
    out->temporary = join(path, ".XXXXXX");
    if (out->temporary == NULL) {
      file_replace_abort(out);
      return out_of_memory(path, error);
    }
    int descriptor = mkstemp(out->temporary);
    if (descriptor >= 0) {
      give_usual_rights(descriptor);
      out->stream = fdopen(descriptor, "wb");
      if (out->stream == NULL) {
        close(descriptor);
        unlink(out->temporary);
      }
    }
  }
  if (out->stream != NULL) return SCREE_OK;
  int reason = errno;
  free(out->temporary);
  free(out->path);
  *out = (file_replacement){0};
  return fail_with(error, SCREE_ERROR_IO, "%s: cannot write: %s", path, strerror(reason));
}

scree_result file_replace_check(const char* path, scree_error* error) {
  struct stat status;
  if (!file_is_replaced(path) && (stat(path, &status) != 0 || !S_ISDIR(status.st_mode))) {
    if (access(path, W_OK) == 0) return SCREE_OK;
    return fail_with(error, SCREE_ERROR_IO, "%s: cannot write: %s", path, strerror(errno));
  }
  file_replacement probe;
  scree_result result = file_replace_begin(path, &probe, error);
  if (result == SCREE_OK) file_replace_abort(&probe);
  return result;
}

scree_result file_replace_commit(file_replacement* file, scree_error* error) {
  bool good = fflush(file->stream) == 0 && ferror(file->stream) == 0;
  int reason = errno;
  if (fclose(file->stream) != 0 && good) {
    good = false;
    reason = errno;
  }
  file->stream = NULL;
  if (good && file->temporary != NULL && rename(file->temporary, file->path) != 0) {
    good = false;
    reason = errno;
  }
  if (!good) {
    fail_with(error, SCREE_ERROR_IO, "%s: cannot write: %s", file->path, strerror(reason));
    file_replace_abort(file);
    return SCREE_ERROR_IO;
  }
  free(file->temporary);
  free(file->path);
  *file = (file_replacement){0};
  return SCREE_OK;
}

void file_replace_abort(file_replacement* file) {
  if (file->stream != NULL) fclose(file->stream);
  if (file->temporary != NULL) {
    unlink(file->temporary);
    free(file->temporary);
  }
  free(file->path);
  *file = (file_replacement){0};
}

scree_result file_scratch(const char* path, FILE** out, scree_error* error) {
  *out = NULL;
  char* name = join(path, ".XXXXXX");
  if (name == NULL) return out_of_memory(path, error);
  int descriptor = mkstemp(name);
  int reason = errno;
  if (descriptor >= 0) {
    unlink(name);
    *out = fdopen(descriptor, "w+b");
    if (*out == NULL) {
      reason = errno;
      close(descriptor);
    }
  }
  free(name);
  return *out != NULL ? SCREE_OK : fail_with(error, SCREE_ERROR_IO, "%s: cannot write beside it: %s", path, strerror(reason));
}

bool file_beside(const char* base, const char* name, char* out, size_t capacity) {
  const char* slash = name[0] == '/' ? NULL : strrchr(base, '/');
  int length =
      slash == NULL ? snprintf(out, capacity, "%s", name) : snprintf(out, capacity, "%.*s/%s", (int)(slash - base), base, name);
  return length >= 0 && (size_t)length < capacity;
}
