/* Command lines. */
#include "arguments.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

static bool fail(scree_error* error, const char* what, const char* which) {
  fail_with(error, SCREE_ERROR_INVALID_ARGUMENT, "%s %s (--help says what there is)", what, which);
  return false;
}

bool arguments_read(int argc, char** argv, const argument* known, size_t known_count, const char** others, size_t others_max,
                    size_t* others_count, scree_error* error) {
  bool only_others = false;
  *others_count = 0;
  for (int i = 1; i < argc; ++i) {
    const char* text = argv[i];
    if (!only_others && strcmp(text, "--") == 0) {
      only_others = true;
      continue;
    }
    if (only_others || text[0] != '-' || text[1] == '\0') {
      if (*others_count == others_max) return fail(error, "unexpected argument", text);
      others[(*others_count)++] = text;
      continue;
    }
    const char* equals = strncmp(text, "--", 2) == 0 ? strchr(text, '=') : NULL;
    size_t length = equals != NULL ? (size_t)(equals - text) : strlen(text);
    const argument* found = NULL;
    for (size_t k = 0; k < known_count && found == NULL; ++k) {
      bool by_name = strlen(known[k].name) == length && strncmp(known[k].name, text, length) == 0;
      if (by_name || (known[k].alias != NULL && strcmp(known[k].alias, text) == 0)) found = &known[k];
    }
    if (found == NULL) return fail(error, "unknown option", text);
    if (found->flag != NULL) {
      if (equals != NULL) return fail(error, "no value is expected for", found->name);
      *found->flag = true;
    } else if (equals != NULL) {
      *found->value = equals + 1;
    } else {
      if (i + 1 == argc) return fail(error, "a value is missing after", text);
      *found->value = argv[++i];
    }
  }
  return true;
}

bool arguments_number(const char* name, const char* text, uint32_t min, uint32_t max, uint32_t* out, scree_error* error) {
  char* end;
  errno = 0;
  unsigned long value = strtoul(text, &end, 10);
  bool good = text[0] >= '0' && text[0] <= '9' && *end == '\0' && errno == 0 && value >= min && value <= max;
  if (!good) {
    fail_with(error, SCREE_ERROR_RANGE, "%s: expected a whole number in %u..%u, got \"%s\"", name, min, max, text);
    return false;
  }
  *out = (uint32_t)value;
  return true;
}
