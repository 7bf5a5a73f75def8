/* What is being weathered, as the renderer shows it: its surface, the ground it stands on, light and a place to look from. */
#ifndef WEATHER_STAGE_H
#define WEATHER_STAGE_H

#include "camera.h"
#include "render.h"
#include "weather_colour.h"
#include "weather_session.h"

typedef struct weather_stage {
  weather_session* session;
  render* renderer;
  render_vertex* vertices;
  uint32_t room;         /* of vertices */
  double mesh_seconds;   /* of the last call of show: the surface, without what the renderer does */
  double upload_seconds; /* of the same: to the renderer */
} weather_stage;

/* Both must outlive the stage. */
void weather_stage_create(weather_stage* stage, weather_session* session, render* renderer);
void weather_stage_destroy(weather_stage* stage);

/* Brings the picture's mesh up to date. Returns SCREE_OK, OUT_OF_MEMORY or what the session says. */
scree_result weather_stage_show(weather_stage* stage, weather_colour colour, scree_error* error);

/* Late sun, sand. */
void weather_stage_light(render_picture* picture);

/* All of the grid in view. aspect: width / height; right: share of the picture's width that something hides at its right side. */
void weather_stage_home(const weather_stage* stage, float aspect, float right, camera* out);

#endif
