/* Reads names of scene files from standard input, one a line, and says of each on one line whether the scene reader accepts it. */
#include <stdio.h>
#include <string.h>

#include "scene.h"

int main(void) {
  char path[1024];
  while (fgets(path, sizeof path, stdin) != NULL) {
    path[strcspn(path, "\n")] = '\0';
    scene_model scene;
    scree_error error = {""};
    if (scene_load(path, &scene, &error) == SCREE_OK) {
      puts("accepted");
      scene_destroy(&scene);
    } else {
      printf("refused: %s\n", error.message);
    }
  }
  return 0;
}
