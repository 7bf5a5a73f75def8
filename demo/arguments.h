/* Command lines: options with and without a value, anything else in order. */
#ifndef ARGUMENTS_H
#define ARGUMENTS_H

#include <scree/base.h>

#ifdef __cplusplus
extern "C" {
#endif

/* One option: `--name VALUE` or `--name=VALUE` when `value` is given, `--name` alone when `flag` is. */
typedef struct argument {
  const char* name;   /* with its dashes */
  const char* alias;  /* "-o", or NULL */
  const char** value; /* where the value goes, or NULL */
  bool* flag;         /* what becomes true, or NULL */
} argument;

/* Reads the arguments after argv[0]. others: room for `others_max`; what stands after `--` goes there too.
 * Returns false with one line in `error`: an unknown option, one without its value, or too many others. */
bool arguments_read(int argc, char** argv, const argument* known, size_t known_count, const char** others, size_t others_max,
                    size_t* others_count, scree_error* error);

/* A whole number of an option. False with a line that names the option when it is none or out of range. */
bool arguments_number(const char* name, const char* text, uint32_t min, uint32_t max, uint32_t* out, scree_error* error);

#ifdef __cplusplus
}
#endif

#endif
