/* Runs the code of the README's first screen on a small pack that lies in the working directory. */
#include <scree/field.h>

#include <stdio.h>
#include <stdlib.h>

int main(void) {
#include "snippet.inc"
  printf("%llu rocks\n", (unsigned long long)count);
  int fine = count > 1000 && rocks != NULL && rocks[count - 1].asset != UINT32_MAX;
  free(rocks);
  scree_support_destroy(hill);
  scree_field_destroy(field);
  scree_pack_close(pack);
  return fine ? 0 : 1;
}
