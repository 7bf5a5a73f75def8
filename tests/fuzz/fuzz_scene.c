/* libFuzzer target: any bytes as a scene. What is accepted is written, read again, and says the same. */
#include "scene.h"

#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  char* exact = malloc(size > 0 ? size : 1);
  memcpy(exact, data, size);
  scene_model scene;
  scree_error error = {""};
  if (scene_parse(exact, size, "fuzz.json", &scene, &error) == SCREE_OK) {
    size_t length, again_length;
    char* text = scene_write(&scene, &length);
    scene_model read;
    if (text == NULL || scene_parse(text, length, "again.json", &read, &error) != SCREE_OK) abort();
    char* again = scene_write(&read, &again_length);
    if (again == NULL || again_length != length || memcmp(text, again, length) != 0) abort();
    scene_destroy(&read);
    free(again);
    free(text);
  } else if (error.message[0] == '\0' || strchr(error.message, '\n') != NULL) {
    abort();
  }
  scene_destroy(&scene);
  free(exact);
  return 0;
}
