/* The panel of weathering by hand, drawn with Dear ImGui: a C face over the one C++ file that knows it. */
#ifndef WEATHER_PANEL_H
#define WEATHER_PANEL_H

#include <scree/hoodoo.h>

#include "weather_colour.h"

#ifdef __cplusplus
extern "C" {
#endif

struct GLFWwindow;
typedef struct weather_panel weather_panel;

/* What the panel shows; the second part it may change. */
typedef struct weather_panel_view {
  const scree_hoodoo_recipe* recipe;
  scree_weather_stats stats;
  uint32_t variant, begun, last, snapshots;
  uint32_t age_steps[SCREE_HOODOO_AGES]; /* when they were reached, UINT32_MAX = not yet */
  uint32_t age_count;
  bool unsaved;
  double step_seconds, mesh_seconds, frame_seconds;
  uint32_t triangles;
  uint64_t sent; /* bytes to the GPU by the last change of the surface */
  const char* keys;
  const char* message;
  bool message_is_error;

  scree_hoodoo_rules rules; /* of the next step */
  bool playing, panel, help, figures, wireframe;
  bool remove_point; /* the selected one is to go */
  float steps_per_second;
  weather_colour colour;
} weather_panel_view;

/* What its buttons ask for. */
typedef struct weather_panel_wishes {
  bool rules; /* were changed */
  bool held;  /* something is being dragged: time had better stand still */
  bool step, restart, save, export_glb, picture, home, keep_age, flatten;
  bool go;
  uint32_t go_to; /* step */
  uint32_t variant;
  uint32_t drop_age, drop_phase; /* UINT32_MAX = none */
} weather_panel_wishes;

/* Call after the window's own callbacks are set: it passes events on to them. NULL when there is no memory. */
weather_panel* weather_panel_create(struct GLFWwindow* window);
void weather_panel_destroy(weather_panel* p);

bool weather_panel_wants_pointer(const weather_panel* p);
bool weather_panel_wants_keys(const weather_panel* p);

/* Lays out and draws into the bound framebuffer. */
void weather_panel_draw(weather_panel* p, weather_panel_view* view, weather_panel_wishes* wishes);

/* Where the durability graph was last drawn, window units; false when it was not. */
bool weather_panel_graph(const weather_panel* p, float min[2], float max[2]);

#ifdef __cplusplus
}
#endif

#endif
