#include "weather_stage.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "timer.h"
#include "weather_mesh.h"

void weather_stage_create(weather_stage* stage, weather_session* session, render* renderer) {
  *stage = (weather_stage){.session = session, .renderer = renderer};
}

void weather_stage_destroy(weather_stage* stage) {
  free(stage->vertices);
  *stage = (weather_stage){0};
}

scree_result weather_stage_show(weather_stage* stage, weather_colour colour, scree_error* error) {
  static const uint8_t rock[3] = {196, 146, 106};
  const scree_hoodoo_recipe* recipe = weather_session_recipe(stage->session);
  const scree_hoodoo_rules* rules = weather_session_rules(stage->session);
  const double start = timer_seconds();
  scree_surface surface;
  scree_result result = weather_session_surface(stage->session, &surface, error);
  if (result != SCREE_OK) return result;
  if (surface.vertex_count > stage->room) {
    const uint32_t room = surface.vertex_count + surface.vertex_count / 4;
    render_vertex* grown = realloc(stage->vertices, room * sizeof *grown);
    if (grown == NULL) return fail_with(error, SCREE_ERROR_OUT_OF_MEMORY, "no memory for the surface");
    stage->vertices = grown;
    stage->room = room;
  }
  const weather_range range = weather_range_of(rules->durability, rules->durability_count);
  weather_mesh_fill(&surface, recipe->size, recipe->voxel, colour, &range, stage->vertices);
  const double filled = timer_seconds();
  stage->mesh_seconds = filled - start;
  result = render_set_free_mesh(stage->renderer, stage->vertices, surface.vertex_count, surface.indices,
                                3 * (surface.rock_triangles + surface.colluvium_triangles),
                                colour == WEATHER_NATURAL ? RENDER_LOOK_HOODOO : RENDER_LOOK_PAINTED, rock);
  stage->upload_seconds = timer_seconds() - filled;
  if (result != SCREE_OK) return fail_with(error, result, "the surface cannot be shown: %s", scree_result_string(result));
  return result;
}

void weather_stage_light(render_picture* picture) {
  static const float sun[3] = {-0.62f, 0.55f, 0.50f}, sand[3] = {0.50f, 0.36f, 0.24f};
  memcpy(picture->sun, sun, sizeof sun);
  memcpy(picture->ground_colour, sand, sizeof sand);
  picture->ground_sand = true;
}

void weather_stage_home(const weather_stage* stage, float aspect, float right, camera* out) {
  const scree_hoodoo_recipe* recipe = weather_session_recipe(stage->session);
  float half[3];
  for (int a = 0; a < 3; ++a) half[a] = 0.5f * (float)(recipe->size[a] * recipe->voxel);
  /* Seldom does anything stand in the corners of the grid. */
  const float radius = sqrtf(half[1] * half[1] + 0.5f * (half[0] * half[0] + half[2] * half[2]));
  const float centre[3] = {0, 0.92f * half[1], 0}, eye[3] = {0.42f, centre[1] + 0.20f, 1};
  camera_look(out, eye, centre, 0.62f);
  camera_frame(out, centre, 0.95f * radius, aspect * (1 - right));
  camera_pan(out, -0.5f * right * aspect, 0);
}
