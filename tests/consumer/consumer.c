#include <scree/pack.h>
#include <scree/support.h>
#include <stdio.h>

int main(void) {
  scree_shape ball = {.kind = SCREE_SHAPE_SPHERE, .sphere = {.radius = 1.0f}};
  printf("scree %s, %s\n", scree_version_string(), scree_result_string(SCREE_OK));
  return ball.sphere.radius > 0 ? 0 : 1;
}
