#include <scree/bake.h>
#include <scree/draco.h>
#include <stdio.h>

int main(void) {
  scree_recipe recipe;
  scree_recipe_default(&recipe);
  scree_error error;
  scree_result result = scree_recipe_set(&recipe, "n=3", &error);
  printf("n = %u, %s; no pack: %s\n", recipe.n, scree_result_string(result),
         scree_result_string(scree_draco_decode_u16(NULL, 0, 0, NULL, 0, NULL, 0)));
  return 0;
}
