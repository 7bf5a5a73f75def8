/* Writes a small pack for the fuzzer to start from; with a second argument, one with proxies. */
#include <stdio.h>
#include <stdlib.h>

#include "make_pack.h"

int main(int count, char** arguments) {
  const test_pack_desc desc = {.shapes = 1, .lod_count = 2, .proxies = count == 3};
  size_t size;
  uint8_t* bytes = test_pack_make(&desc, &size);
  FILE* file = count >= 2 ? fopen(arguments[1], "wb") : NULL;
  int status = file == NULL || fwrite(bytes, 1, size, file) != size || fclose(file) != 0;
  free(bytes);
  return status;
}
