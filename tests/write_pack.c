/* Writes a small pack for the fuzzer and for tests of programs to start from; with "proxies" behind the file, one with proxies,
 * with "models" one of models, with "cliff" one of a cliff. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "make_model_pack.h"
#include "make_pack.h"

int main(int count, char** arguments) {
  const char* what = count == 3 ? arguments[2] : "";
  const test_pack_desc desc = {.shapes = 1, .lod_count = 2, .proxies = strcmp(what, "proxies") == 0};
  size_t size;
  uint8_t* bytes = strcmp(what, "models") == 0  ? test_model_pack_make(NULL, &size)
                   : strcmp(what, "cliff") == 0 ? test_model_pack_make(&(test_models_desc){.variants = 4, .cliff = true}, &size)
                                                : test_pack_make(&desc, &size);
  FILE* file = count >= 2 ? fopen(arguments[1], "wb") : NULL;
  int status = file == NULL || fwrite(bytes, 1, size, file) != size || fclose(file) != 0;
  free(bytes);
  return status;
}
