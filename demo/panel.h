/* The panel of scree-view, drawn with Dear ImGui: a C face over the one C++ file that knows it. */
#ifndef PANEL_H
#define PANEL_H

#include "edit.h"
#include "render.h"

#ifdef __cplusplus
extern "C" {
#endif

struct GLFWwindow;
typedef struct panel panel;

/* What the panel shows; what it may change is behind pointers. */
typedef struct panel_view {
  editor* edit;
  const char* packs;         /* folder of packs to offer */
  bool panel, help, figures; /* which of its parts are open; the panel may close them */
  render_stats stats;
  const uint32_t* stone_counts; /* one a field */
  uint32_t times;               /* of the selected field's cliff; 0 otherwise */
  uint32_t mesh_times;          /* of the pack that the selected support is a mesh of; 0 otherwise */
  double frame_seconds, query_seconds;
  const char* message; /* the last thing that happened, may be empty */
  bool message_is_error;
  double place[3], size; /* where a new support stands and how large it is, metres */
  render_colour colour;
  bool wireframe, flying;
} panel_view;

/* What its buttons ask for. */
typedef struct panel_wishes {
  bool save, picture, home, undo, redo;
} panel_wishes;

/* Call after the window's own callbacks are set: it passes events on to them. NULL when there is no memory. */
panel* panel_create(struct GLFWwindow* window);
void panel_destroy(panel* p);

/* Does the pointer or the keyboard belong to the panel just now? */
bool panel_wants_pointer(const panel* p);
bool panel_wants_keys(const panel* p);

/* Lays out and draws into the bound framebuffer. */
void panel_draw(panel* p, panel_view* view, panel_wishes* wishes);

#ifdef __cplusplus
}
#endif

#endif
